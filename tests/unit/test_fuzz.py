"""Damaged inputs and bombs: refused by name, in bounded memory; nothing crashes."""

import random
from collections.abc import Callable
from pathlib import Path

import pytest

from sceneq_nodes._reason_json import problem_from_bytes, verdict_from_bytes
from sceneq_schemas.errors import DecodeError
from sceneq_tools.chaos import bombs, fuzz
from sceneq_tools.chaos.decoder import CountedError, Decoder
from sceneq_tools.chaos.fuzz_worker import feed, inputs
from sceneq_tools.chaos.mutation import BYTES, JSON, MSGPACK, Mutator
from sceneq_tools.chaos.scenario import Outcome, Plan
from sceneq_tools.chaos.wire_decoders import message_decoders, other_decoders

EACH = 40
"""Inputs of every decoder; `sceneq chaos fuzz` gives each some thousands."""


@pytest.fixture(scope="module")
def thrown(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Outcome]:
    plan = Plan(tmp_path_factory.mktemp("bombs"))
    return {outcome.fault.removeprefix("bomb: "): outcome for outcome in bombs.run(plan)}


@pytest.mark.parametrize("name", bombs.bombs())
def test_a_bomb_is_refused(name: str, thrown: dict[str, Outcome]) -> None:
    assert thrown[name].passed, thrown[name]


def test_damaged_inputs_harm_no_decoder(tmp_path: Path) -> None:
    names = fuzz.decoder_names(tmp_path)
    assert len(names) > 60
    found = [fuzz.outcome(result) for result in fuzz.fed(names, EACH, 0, tmp_path)]
    assert [one.times for one in found] == [EACH] * len(names)
    assert not [one for one in found if not one.passed]


@pytest.mark.parametrize("decoder", [*message_decoders(), *other_decoders()], ids=lambda d: d.name)
def test_the_undamaged_ones_decode(decoder: Decoder) -> None:
    assert decoder.seeds
    for seed in decoder.seeds:
        decoder.decode(seed)


@pytest.mark.parametrize("form", [BYTES, JSON, MSGPACK])
def test_the_same_seed_gives_the_same_damage(form: str) -> None:
    seed = {
        BYTES: b"some bytes",
        JSON: b'{"a":[1,2.5,"b"]}',
        MSGPACK: b"\x81\xa1a\x93\x01\x02\xa1b",
    }

    def damaged(number: int) -> list[bytes]:
        mutator = Mutator((seed[form],), form, random.Random(number))
        return [mutator.next() for _ in range(50)]

    assert damaged(1) == damaged(1)
    assert damaged(1) != damaged(2)
    assert len(set(damaged(1))) > 30


def test_what_becomes_of_inputs_is_counted() -> None:
    def decode(data: bytes) -> None:
        error: Exception | None = {
            b"bad": DecodeError("bad"),
            b"counted": CountedError("frames_refused"),
            b"crash": KeyError("a bug"),
        }.get(data)
        if error is not None:
            raise error

    decoder = Decoder("toy", decode, (b"",), BYTES, (DecodeError, CountedError))
    told = feed(decoder, [b"", b"bad", b"counted", b"crash", b"bad"])
    assert (told["inputs"], told["accepted"], told["crashes"]) == (5, 1, 1)
    assert told["refused"] == {"DecodeError": 2, "frames_refused": 1}
    assert told["crash_examples"] == ["input 4: KeyError: 'a bug'"]
    judged = fuzz.outcome(told)
    assert not judged.passed
    assert judged.verdict == "FAILED"


def test_a_worker_that_dies_is_a_crash_and_the_rest_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    usual: Callable[..., list[str]] = fuzz._command
    fatal = "import sys; open(sys.argv[1], 'wb').write(bytes([9] + [0] * 7)); sys.exit(7)"

    def command(each: int, seed: int, folder: Path, names: list[str]) -> list[str]:
        if names[0] == "health":
            return [usual(each, seed, folder, names)[0], "-c", fatal, str(folder / "progress")]
        return usual(each, seed, folder, names)

    monkeypatch.setattr(fuzz, "_command", command)
    died, fine = fuzz.fed(["health", "verdict"], 5, 0, tmp_path)
    assert died["crash_examples"] == ["input 9 ended the process with code 7"]
    assert (fine["decoder"], fine["inputs"], fine["crashes"]) == ("verdict", 5, 0)


def test_inputs_are_damaged_copies_of_the_seeds() -> None:
    decoder = next(message_decoders())
    made = list(inputs(decoder, 20, 3))
    assert made == list(inputs(decoder, 20, 3))
    assert not set(made) <= set(decoder.seeds)


def test_numbers_beyond_a_float_are_refused_or_scaled() -> None:
    known = {decoder.name: decoder for decoder in other_decoders()}
    verdict, problem = known["verdict"].seeds[0], known["problem"].seeds[0]
    with pytest.raises(DecodeError):
        verdict_from_bytes(verdict.replace(b"0.5", b"9" * 400))
    up = problem.replace(b"[0.0,0.0,1.0]", b"[3e300,0,4e300]", 1)
    assert problem_from_bytes(up).up_world.tolist() == pytest.approx([0.6, 0.0, 0.8])
