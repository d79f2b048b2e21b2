"""The synthetic suite: which rooms, what is made again, and what is refused."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from sceneq_tools.cli import app
from sceneq_tools.errors import UserError
from sceneq_tools.evaluation.suite_recordings import frames_digest, recordings_of
from sceneq_tools.room.room import KINDS
from sceneq_tools.suite import ROOMS as ALL_ROOMS
from sceneq_tools.suite import (
    SUITE_FILE,
    TEST,
    TUNING,
    SuiteParams,
    make_suite,
    read_suite,
    rooms_of,
)
from sceneq_tools.synth import SynthParams

from support.tiny_suite import ROOMS, write_room, write_suite

PARAMS = SuiteParams(frames=2, size=(64, 48))


@pytest.fixture
def made() -> list[str]:
    return []


def make(out: Path, made: list[str], params: SuiteParams = PARAMS, library: str = "shapes") -> int:
    def note(room: SynthParams, folder: Path) -> None:
        made.append(folder.name)
        write_room(room, folder)

    return make_suite(out, params, library, note, quiet=True, rooms=ROOMS)


def test_half_of_the_eight_rooms_may_be_tuned_on() -> None:
    assert [room.split for room in ALL_ROOMS] == [TUNING] * 4 + [TEST] * 4
    assert len({(room.kind, room.seed) for room in ALL_ROOMS}) == 8
    assert {room.kind for room in ALL_ROOMS} == set(KINDS)
    seeds = [{room.seed for room in ALL_ROOMS if room.split == s} for s in (TUNING, TEST)]
    assert not seeds[0] & seeds[1]


def test_every_further_round_has_other_seeds_and_tests_all_kinds() -> None:
    rooms = rooms_of(3)
    assert rooms_of(1) == rooms[:8] == ALL_ROOMS
    assert len(set(rooms)) == 8 + 2 * 9
    seeds = [{room.seed for room in rooms if room.split == s} for s in (TUNING, TEST)]
    assert seeds == [{11, 12, 13}, {21, 22, 23}]
    assert {room.kind for room in rooms if room.seed == 22} == set(KINDS)
    for wrong in (0, 10):
        with pytest.raises(ValueError, match=f"rounds: expected 1 to 9, got {wrong}"):
            rooms_of(wrong)


def test_a_room_is_recorded_as_the_suite_says() -> None:
    params = SuiteParams(frames=30).of(ALL_ROOMS[0])
    assert (params.seed, params.kind, params.frames) == (11, "kitchen", 30)
    assert (params.rate_hz, params.size, params.changes, params.clean) == (
        2.0,
        (640, 480),
        0,
        False,
    )


@pytest.mark.parametrize("wrong", [{"frames": 0}, {"every": 0}, {"rate_hz": 0.0}])
def test_parameters_that_make_no_sense_are_named(wrong: dict) -> None:
    with pytest.raises(ValueError, match=next(iter(wrong))):
        SuiteParams(**wrong)


def test_what_is_complete_is_not_made_again(tmp_path: Path, made: list[str]) -> None:
    assert make(tmp_path, made) == 2
    assert make(tmp_path, made) == 0
    assert made == ["tuning_office_1", "test_kitchen_2"]
    (tmp_path / "test_kitchen_2" / "frame-000001.depth.png").unlink()
    assert make(tmp_path, made) == 1
    assert made[2:] == ["test_kitchen_2"]


@pytest.mark.parametrize(
    ("params", "library"), [(SuiteParams(frames=3, size=(64, 48)), "shapes"), (PARAMS, "others")]
)
def test_what_was_made_otherwise_is_made_again(
    tmp_path: Path, made: list[str], params: SuiteParams, library: str
) -> None:
    make(tmp_path, made)
    assert make(tmp_path, made, params, library) == 2


def test_a_suite_that_was_interrupted_is_none(tmp_path: Path, made: list[str]) -> None:
    make(tmp_path, made)

    def fail(params: SynthParams, folder: Path) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        make_suite(tmp_path, SuiteParams(frames=5), "shapes", fail, quiet=True, rooms=ROOMS)
    with pytest.raises(UserError, match="neither a suite nor a recording with truth"):
        recordings_of([tmp_path])
    assert make(tmp_path, made) == 1  # the other room is as it was


def test_the_rooms_come_by_split_with_their_keyframes(tmp_path: Path) -> None:
    suite = write_suite(tmp_path / "suite")
    write_room(SynthParams(frames=2), tmp_path / "mine")
    found = recordings_of([tmp_path / "mine", suite])
    assert [(one.name, one.split, one.every) for one in found] == [
        ("tuning_office_1", "tuning", 1),
        ("test_kitchen_2", "test", 1),
        ("mine", "given", None),
    ]
    assert found[0].made_by.endswith(", ray-cast")
    assert [one.every for one in recordings_of([tmp_path / "mine", suite], 7)] == [7, 7, 7]
    with pytest.raises(UserError, match="mine: two recordings have this name"):
        recordings_of([tmp_path / "mine", tmp_path / "mine"])


def test_a_malformed_suite_is_named(tmp_path: Path) -> None:
    suite = write_suite(tmp_path / "suite", frames=2)
    path = suite / SUITE_FILE
    document = json.loads(path.read_text())
    for change, says in (
        ({"schema": "other"}, "schema 'other', expected 'sceneq.suite.v1'"),
        ({"rooms": [{"folder": "tuning_office_1"}]}, "no field 'split'"),
        ({"frames": 9}, "not complete"),
    ):
        path.write_text(json.dumps({**document, **change}))
        with pytest.raises(UserError, match=says):
            read_suite(suite)
    path.write_text("{")
    with pytest.raises(UserError, match=r"suite\.json: no JSON"):
        read_suite(suite)


def test_the_digest_follows_every_byte_but_the_readme(tmp_path: Path) -> None:
    write_room(SynthParams(frames=2), tmp_path)
    before = frames_digest(tmp_path)
    (tmp_path / "README.md").write_text("other")
    assert frames_digest(tmp_path) == before
    (tmp_path / "frame-000001.pose.txt").write_text("other")
    assert frames_digest(tmp_path) != before


def test_the_command_makes_eight_rooms_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from sceneq_tools import synth_command

    monkeypatch.setattr(synth_command, "_synth", lambda params, out, *_: write_room(params, out))
    arguments = ["synth", str(tmp_path / "rooms"), "--suite", "--frames", "2"]
    for says in ("8 rooms made, 0 were there", "0 rooms made, 8 were there"):
        done = CliRunner().invoke(app, arguments)
        assert (done.exit_code, done.exception) == (0, None)
        assert done.stdout.startswith(says)
    assert len(recordings_of([tmp_path / "rooms"])) == 8
    done = CliRunner().invoke(app, [*arguments, "--seed", "3", "--clean"])
    assert "--suite and --seed, --clean" in str(done.exception)


def test_a_room_alone_has_no_rounds(tmp_path: Path) -> None:
    done = CliRunner().invoke(app, ["synth", str(tmp_path / "room"), "--rounds", "2"])
    assert isinstance(done.exception, UserError)
    assert str(done.exception) == "--rounds 2: only with --suite, one room alone has no rounds"
    assert not (tmp_path / "room").exists()
