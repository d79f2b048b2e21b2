"""What scenarios tell, how they are run, and the table of policies in docs/reliability.md."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from sceneq_tools.chaos import policy, running
from sceneq_tools.chaos.known import Known
from sceneq_tools.chaos.overload import judged
from sceneq_tools.chaos.registry import SCENARIOS, SHORT, load
from sceneq_tools.chaos.running import as_json, command, outcomes, rows
from sceneq_tools.chaos.scenario import NOTHING, Outcome, Plan, skipped

PAGE = Path(__file__).parents[2] / "docs" / "reliability.md"


def test_every_scenario_can_be_loaded() -> None:
    assert all(callable(load(name)) for name in SCENARIOS)
    assert set(SHORT) <= set(SCENARIOS)


def test_an_outcome_says_ok_failed_or_skipped() -> None:
    assert Outcome("kill", 3, NOTHING, True).verdict == "ok"
    assert Outcome("kill", 3, "digest", False).verdict == "FAILED"
    assert skipped("cut", "unshare: not permitted").verdict == "skipped"
    with pytest.raises(ValueError, match="count: must be at least 1, got 0"):
        Plan(Path(), count=0)
    assert Plan(Path()).pick(9, 2) == 9
    assert Plan(Path(), short=True).pick(9, 2) == 2


def test_scenarios_run_in_folders_of_their_own(monkeypatch: pytest.MonkeyPatch) -> None:
    plans: list[Plan] = []

    def scenario(plan: Plan) -> Iterator[Outcome]:
        plans.append(plan)
        (plan.together / "seen").touch()
        yield Outcome("one", 1, NOTHING, True)
        if len(plans) > 1:
            raise RuntimeError("the graph has ended")

    monkeypatch.setattr(running, "load", lambda name: scenario)
    found = list(outcomes(["a", "b"], 5, True, 10))
    assert [(name, one.fault, one.passed) for name, one in found] == [
        ("a", "one", True),
        ("b", "one", True),
        ("b", "b", False),
    ]
    assert "RuntimeError after 0 s: the graph has ended" in found[-1][1].detail
    assert plans[0].work != plans[1].work
    assert plans[0].together == plans[1].together
    assert (plans[0].seed, plans[0].short, plans[0].count) == (5, True, 10)
    assert not plans[0].together.exists()


def test_the_table_says_how_to_do_it_again() -> None:
    done = {"fuzz": [Outcome("damaged health", 7, NOTHING, True, "7 refused\nand more")]}
    assert list(rows(done, 3, 100)) == [
        (
            "damaged health",
            "7",
            NOTHING,
            "ok",
            "7 refused",
            "sceneq chaos fuzz --seed 3 --count 100",
        )
    ]
    assert command("kill", 0, 200_000) == "sceneq chaos kill --seed 0"
    (told,) = as_json(done, 3, 100)["outcomes"]
    assert told["scenario"] == "fuzz"
    assert told["passed"] is True


def test_what_differs_is_named_with_its_place() -> None:
    views = '{"7": [{"seq": [3, 0], "px": 4}]}'
    whole = Known("aa", '[{"id": 1, "views": [{"seq": 5}]}]', views, "{}", "[]")
    assert whole.lost(whole) == NOTHING
    other = replace(whole, instances='[{"id": 1, "views": [{"seq": 7}]}]')
    assert other.lost(whole) == "instances (instances[0].views[0].seq: 7 is not 5)"
    assert other.lost_but_views(whole) == "nothing of the map; views chosen anew"
    smaller = replace(whole, views=views.replace("4", "2"))
    assert smaller.lost(whole) == "views (views.7[0].px: 2 is not 4)"
    gone = replace(whole, digest="bb", instances="[]")
    assert gone.lost_but_views(whole).startswith("digest, instances (digest bb, not aa)")


def test_overload_must_account_for_every_frame() -> None:
    told = {"sent": 90, "dropped by mapping": 60, "unmatched in mapping": 2}
    answers = [("answered", 5.0), ("answered", 9.0)]
    assert judged(NOTHING, 4.0, 28, told, answers).passed
    assert not judged(NOTHING, 4.0, 27, told, answers).passed
    assert not judged("the map", 4.0, 28, told, answers).passed
    assert not judged(NOTHING, 4.0, 28, told, [*answers, ("timeout", 900.0)]).passed


def test_the_policy_of_every_topic_is_in_the_docs() -> None:
    hint = "write it anew: python -m sceneq_tools.chaos.policy"
    assert policy.as_markdown() in PAGE.read_text(), hint
