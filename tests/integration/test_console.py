"""The console in a real browser, on a running graph."""

import contextlib
import os
import re
import shutil
import signal
from collections.abc import Iterator

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Browser, Locator, Page, expect, sync_playwright

from support.live_graph import LiveGraph
from support.shared_room import SharedRoom

CHROMIUM = shutil.which("chromium") or shutil.which("google-chrome")

pytestmark = [
    pytest.mark.integration,
    pytest.mark.skipif(CHROMIUM is None, reason="no Chromium here: make browser"),
]

PATIENT_MS = 60_000
TRIES = 10
FOCUSED = """(() => {
    const at = document.activeElement;
    return at.labels?.[0]?.innerText ?? at.innerText;
})()"""
BLOCKING = """performance.getEntriesByType("resource")
    .filter((one) => one.renderBlockingStatus === "blocking")
    .map((one) => one.decodedBodySize)"""


@pytest.fixture(scope="module")
def live(room: SharedRoom) -> LiveGraph:
    return room.live


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    expect.set_options(timeout=PATIENT_MS)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=CHROMIUM, args=["--no-sandbox", "--enable-unsafe-swiftshader"]
        )
        yield browser
        browser.close()


@pytest.fixture
def page(live: LiveGraph, browser: Browser) -> Iterator[Page]:
    page = browser.new_page(viewport={"width": 1280, "height": 800})
    page.set_default_timeout(PATIENT_MS)
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    address = live.wait(lambda: re.search(r"open (http://\S+) in a browser", live.log.read_text()))
    page.goto(address[1])
    expect(page.locator("#list li").first).to_be_attached()
    yield page
    page.close()
    assert not errors


def ask(page: Page, question: str) -> None:
    page.get_by_label("What are you looking for?").fill(question)
    page.keyboard.press("Enter")
    expect(page.locator(".card h2").first).to_have_text(question)
    expect(page.locator(".card .status").first).not_to_have_text("asking …")


def test_an_answer_is_shown_with_evidence_and_in_the_map(page: Page) -> None:
    ask(page, "red ball")
    thing = page.locator(".card").first.locator(".thing").first
    expect(thing.locator("img")).to_have_attribute("src", re.compile("^blob:"))
    expect(thing.locator(".frame i")).to_be_visible()
    expect(thing.locator("output")).to_have_text(re.compile(r"^(<1|\d+) %$"))
    chosen = thing.get_attribute("data-id")
    expect(page.locator("#cloud")).to_have_attribute("data-chosen", str(chosen))
    expect(page.locator(".card .why").first).to_contain_text(" ms")
    page.get_by_label("What are you looking for?").fill("")
    page.keyboard.press("ArrowUp")
    expect(page.get_by_label("What are you looking for?")).to_have_value("red ball")


def test_a_newcomer_is_shown_what_to_ask(page: Page) -> None:
    proposed = page.locator("#try button")
    question = proposed.first.inner_text()
    proposed.first.click()
    expect(page.locator(".card h2").first).to_have_text(question)
    expect(page.locator(".card .status").first).not_to_have_text("asking …", timeout=PATIENT_MS)
    expect(page.locator("#try")).to_be_hidden()


def test_a_thing_is_asked_about_by_a_click_in_the_map(page: Page) -> None:
    box = page.locator("#cloud").bounding_box()
    assert box is not None
    said = page.locator(".card .said").first
    for _ in range(TRIES):  # until the points are there
        page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
        with contextlib.suppress(AssertionError):
            expect(said).to_contain_text("It may be: ", timeout=PATIENT_MS / TRIES)
            break
    expect(said).to_contain_text("It may be: ")


def test_a_thing_gets_a_name_and_answers_to_it(page: Page) -> None:
    ask(page, "yellow ball")
    thing = page.locator(".card").first.locator(".thing").first
    number = thing.get_attribute("data-id")
    thing.get_by_role("button", name="Call it").click()
    page.keyboard.type("Ada's moon")
    page.keyboard.press("Enter")
    expect(thing.locator("h3")).to_have_text(f"Ada's moon ({number})")
    ask(page, "Ada's moon")
    expect(page.locator(".card").first.locator(".thing").first).to_have_attribute(
        "data-id", str(number)
    )


def test_which_one_is_said_and_the_wrong_one_is_put_away(page: Page) -> None:
    ask(page, "red ball")
    expect(page.locator(".card .status").first).to_have_text("which one?")
    things = page.locator(".card").first.locator(".thing")
    first = things.first.get_attribute("data-id")
    things.first.get_by_role("button", name="Not this one").click()
    expect(things.first).not_to_have_attribute("data-id", str(first))


def test_no_answer_is_said(page: Page) -> None:
    page.route("**/ask", lambda route: route.fulfill(
        status=503, content_type="application/problem+json",
        body='{"status": 503, "title": "Too busy", "detail": "nobody answers answer"}',
    ))  # fmt: skip
    ask(page, "red ball")
    expect(page.locator(".card .status").first).to_have_text("no answer")
    expect(page.locator(".card .said").first).to_have_text("nobody answers answer")


def test_a_node_is_seen_to_die_to_hang_and_to_come_back(page: Page) -> None:
    node = page.locator("#nodes li", has_text="segmentation")
    os.kill(process_of(node), signal.SIGKILL)
    expect(node).to_contain_text("restarted once")  # it may be back before it is missed
    expect(node).to_have_class("")
    os.kill(process_of(node), signal.SIGSTOP)
    expect(node).to_have_class("gone")
    expect(node).to_contain_text("restarted 2 times")  # the watchdog has replaced it
    expect(node).to_have_class("")


def process_of(node: Locator) -> int:
    """Return the process whose heartbeat the page heard last."""
    expect(node).to_have_class("")
    found = re.search(r"\(process (\d+)\)", node.get_attribute("title") or "")
    assert found is not None
    return int(found[1])


def test_the_connection_is_lost_and_found_again(live: LiveGraph, page: Page) -> None:
    os.kill(live.pids()["gateway"], signal.SIGKILL)
    expect(page.get_by_role("alert")).to_be_visible()
    expect(page.get_by_role("alert")).to_be_hidden()
    ask(page, "red ball")
    expect(page.locator(".card").first.locator(".thing").first).to_be_visible()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_screen_reader_finds_its_way(page: Page, scheme: str) -> None:
    page.emulate_media(color_scheme=scheme)  # type: ignore[arg-type]
    ask(page, "red ball")
    page.locator("#things summary").click()
    expect(page.locator(".card .frame i").first).to_be_visible()
    result = Axe().run(page)
    assert result.violations_count == 0, result.generate_report()


def test_it_fits_a_phone_and_needs_no_mouse(page: Page) -> None:
    page.set_viewport_size({"width": 390, "height": 844})
    ask(page, "red ball")
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    page.get_by_label("What are you looking for?").focus()
    for name in ("Ask", "think longer: let the reasoner decide", "Show"):
        page.keyboard.press("Tab")
        focused = (
            "document.activeElement.labels?.[0]?.innerText ?? document.activeElement.innerText"
        )
        assert page.evaluate(focused).strip() == name
    page.locator("#cloud").focus()
    page.keyboard.press("ArrowLeft")
    page.keyboard.press("+")


def test_it_is_painted_within_a_second(page: Page) -> None:
    page.reload()
    paint = "performance.getEntriesByName('first-contentful-paint')[0]?.startTime"
    page.wait_for_function(paint)
    # Not a measurement of speed: what is waited for before the first paint would be seconds.
    sizes = page.evaluate(BLOCKING)
    assert 0 < sum(sizes) < 50_000
