"""The documents agree with the code, and no command in them is one that nobody runs."""

import json
import re
import shlex
import tomllib

import pytest
import typer

from support.command_line import parsed
from support.command_ways import ROWS, Way, row_of, shortened
from support.documents import (
    ROOT,
    SHELL,
    Command,
    anchors,
    blocks,
    commands,
    links,
    mentioned,
    pages,
    prose,
)
from support.reader import STAND_INS

PAGES = pages()
TYPED = [command for page in PAGES for command in commands(page)]
MENTIONED = [command for page in PAGES for command in mentioned(page)]
OTHERS = re.compile(r"(ros2|mcap|rerun|apt-get|export|source|bash|python3?) ")
"""Programs of others, in sentences: named, not ours to test."""
PLACEHOLDER = re.compile(r"\bN\b")


def readable(command: Command) -> str:
    """Return a mentioned command without the brackets around what may be left out."""
    text = re.sub(r"\[(--.*?)\]", r"\1", command.text)
    return PLACEHOLDER.sub("2", text)


def test_every_command_has_a_way_in_which_it_is_run() -> None:
    assert len(TYPED) > 100
    ways = {row_of(command).way for command in TYPED}
    assert ways == set(Way)


def test_no_row_is_left_over() -> None:
    used = {row_of(command) for command in TYPED}
    assert {row.pattern for row in ROWS} == {row.pattern for row in used}


def test_no_stand_in_is_left_over() -> None:
    unused = [text for text in STAND_INS if not any(text in c.text for c in TYPED)]
    assert not unused


def test_what_is_run_elsewhere_is_there() -> None:
    named = {row.detail for row in ROWS if row.way in (Way.ELSEWHERE, Way.SHORTENED)}
    assert not {name for name in named if not (ROOT / "tests" / name).is_file()}


def test_no_command_is_only_read() -> None:
    """Those that take too long are typed too, by a test that asks the table for them."""
    assert {way.name for way in Way} == {
        *("ALONE", "BESIDE", "STAYS", "STORY", "ELSEWHERE", "SHORTENED", "MAKE")
    }
    short = [row for row in ROWS if row.way is Way.SHORTENED]
    assert all(row.more for row in short)
    for name in {row.detail for row in short}:
        test = ROOT / "tests" / name
        assert "shortened(__file__)" in test.read_text(), name
        assert shortened(str(test)), name
    typed = [
        c for row in {row.detail for row in short} for c in shortened(str(ROOT / "tests" / row))
    ]
    bare = {c.text.partition("  #")[0].rstrip() for c in TYPED if row_of(c).way is Way.SHORTENED}
    assert {c.text.partition("  #")[0].rstrip() for c in typed} == bare


def test_a_command_nobody_knows_is_an_error() -> None:
    with pytest.raises(LookupError, match=r"docs/x\.md:3: nobody has said how to run 'rm -rf /'"):
        row_of(Command("docs/x.md", 3, "rm -rf /"))


def test_prompts_stand_in_blocks_that_are_looked_into() -> None:
    hidden = [
        f"{block.page}:{block.line} ({block.language})"
        for page in PAGES
        for block in blocks(page)
        if block.language not in SHELL and any(line.startswith("$ ") for line in block.lines)
    ]
    assert not hidden


@pytest.mark.parametrize("page", PAGES)
def test_our_command_line_knows_every_word(page: str) -> None:
    ours = [c for c in (*mentioned(page), *commands(page)) if c.text.startswith("sceneq ")]
    for command in ours:
        try:
            parsed(shlex.split(readable(command), comments=True)[1:])
        except typer.TyperException as error:
            pytest.fail(f"{command.where}: {command.text}: {error}")


def test_faults_and_benches_are_those_there_are() -> None:
    from sceneq_tools.bench.registry import BENCHES
    from sceneq_tools.chaos.registry import SCENARIOS

    for command in (*TYPED, *MENTIONED):
        for start, names in (("sceneq chaos ", SCENARIOS), ("sceneq bench ", BENCHES)):
            if command.text.startswith(start):
                said = parsed(shlex.split(readable(command), comments=True)[1:])
                assert set(said.get("scenario") or said.get("stage") or ()) <= set(names), command


def test_what_is_mentioned_is_ours_or_known() -> None:
    known = re.compile(r"(sceneq|zenoh|make|pip install|pytest|[A-Z_]+=) ?")
    rest = [c for c in MENTIONED if not known.match(c.text) and not OTHERS.match(c.text)]
    assert not [f"{c.where}: {c.text}" for c in rest]


def test_extras_are_those_of_the_package() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    texts = "\n".join((ROOT / page).read_text() for page in PAGES)
    extras = {
        name for found in re.findall(r"sceneq\[([\w,-]+)\]", texts) for name in found.split(",")
    }
    assert extras - project["optional-dependencies"].keys() == set()
    assert project["optional-dependencies"].keys() - extras <= {"dev"}


def test_targets_of_make_are_there() -> None:
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.M))
    said = {c.text.split()[1] for c in (*TYPED, *MENTIONED) if c.text.startswith("make ")}
    assert said <= targets


@pytest.mark.parametrize("page", PAGES)
def test_links_lead_somewhere(page: str) -> None:
    """The site's own builder checks those of docs/ too, but not those that GitHub follows."""
    for line, link in links(page):
        path, _, anchor = link.partition("#")
        target = ((ROOT / page).parent / path).resolve() if path else ROOT / page
        made = target.name in ("configuration.md", "messages.md", "licences.md", "index.md")
        assert target.exists() or (made and page.startswith("docs/")), f"{page}:{line}: {link}"
        if anchor and target.suffix == ".md" and target.exists():
            assert anchor in anchors(target), f"{page}:{line}: {link}"


FILE = re.compile(
    r"(?<![\w./*{-])(?:tests|docs|nodes|tools|schemas|deploy|sceneq_core)/[\w./-]+\.\w+"
)


@pytest.mark.parametrize("page", PAGES)
def test_files_that_are_named_exist(page: str) -> None:
    if page.startswith("docs/adr/"):
        return  # a record of its day
    for line, text in prose(page):
        for name in FILE.findall(text):
            assert (ROOT / name).exists(), f"{page}:{line}: {name}"


def test_shown_answers_are_json() -> None:
    """integration/test_questions.py asks for these and compares their fields."""
    shown = [c for c in TYPED if row_of(c).detail == "integration/test_questions.py"]
    assert len(shown) >= 9
    assert all(json.loads(command.shown)["status"] for command in shown)
