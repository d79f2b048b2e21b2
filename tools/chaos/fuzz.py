"""Damaged inputs for every decoder: none may crash, hang, or take more memory than a limit."""

import json
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from sceneq_tools.chaos.fuzz_worker import NUMBER
from sceneq_tools.chaos.scenario import NOTHING, Outcome, Plan

MEMORY_MB = 512
"""A decoder may make the process grow by so much, whatever it is given."""
SLOWEST_MS = 2_000.0
"""More than that for one input would hold up a node."""
SHORT_COUNT = 4_000


def run(plan: Plan) -> Iterator[Outcome]:
    """Yield one outcome for every decoder."""
    names = decoder_names(plan.work)
    count = min(plan.count, SHORT_COUNT) if plan.short else plan.count
    each = -(-count // len(names))
    for result in fed(names, each, plan.seed, plan.work):
        yield outcome(result)


def decoder_names(work: Path) -> list[str]:
    """Return the names of all decoders."""
    folder = _fresh(work, "names")
    done = subprocess.run(_command(0, 0, folder, []), capture_output=True, text=True, check=True)
    names: list[str] = json.loads(done.stdout)
    return names


def fed(names: Sequence[str], each: int, seed: int, work: Path) -> Iterator[dict[str, Any]]:
    """Yield what became of ``each`` inputs of every decoder.

    A worker that dies, or does not end, is a crash of the decoder it was at; another one goes on
    with the rest.
    """
    waiting, tries = list(names), 0
    while waiting:
        folder, tries = _fresh(work, f"files-{tries}"), tries + 1
        (folder / "progress").write_bytes(bytes(NUMBER.size))
        with subprocess.Popen(
            _command(each, seed, folder, waiting),
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        ) as worker:
            assert worker.stdout is not None
            for line in worker.stdout:
                yield json.loads(line)
                del waiting[0]
        if waiting:
            at = NUMBER.unpack((folder / "progress").read_bytes())[0]
            yield _death(waiting.pop(0), at, worker.returncode)


def outcome(result: dict[str, Any]) -> Outcome:
    """Return what a worker said of a decoder, judged."""
    refused = sum(result["refused"].values())
    kinds = ", ".join(f"{n} {kind}" for kind, n in list(result["refused"].items())[:3])
    detail = (
        f"{result['accepted']} accepted, {refused} refused ({kinds or 'none'}), "
        f"{result['crashes']} crashed, slowest {result['slowest_ms']:.0f} ms, "
        f"+{result['peak_mb']:.0f} MB"
    )
    fine = result["crashes"] == 0 and result["slowest_ms"] <= SLOWEST_MS
    lost = NOTHING if fine else "; ".join(result["crash_examples"]) or "time"
    return Outcome(f"damaged {result['decoder']}", result["inputs"], lost, fine, detail)


def _death(name: str, at: int, code: int) -> dict[str, Any]:
    return {
        "decoder": name,
        "inputs": at,
        "accepted": 0,
        "refused": {},
        "crashes": 1,
        "crash_examples": [f"input {at} ended the process with code {code}"],
        "slowest_ms": 0.0,
        "slowest_input": at,
        "peak_mb": 0.0,
    }


def _command(each: int, seed: int, folder: Path, names: Sequence[str]) -> list[str]:
    numbers = [str(number) for number in (each, seed, MEMORY_MB)]
    files = [str(_fresh(folder, "scratch")), str(folder / "progress")]
    return [sys.executable, "-m", "sceneq_tools.chaos.fuzz_worker", *numbers, *files, *names]


def _fresh(parent: Path, name: str) -> Path:
    folder = parent / name
    folder.mkdir()
    return folder
