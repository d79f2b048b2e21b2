"""The process in which decoders are fed: ``python -m sceneq_tools.chaos.fuzz_worker``.

Its arguments are count, seed, memory limit in MiB, a folder for scratch files, the file that holds
the number of the present input, and the names of decoders (none: print all names). It prints a
line of JSON for every decoder; when it dies in the middle, the file says at which input.
"""

import contextlib
import json
import logging
import mmap
import os
import random
import resource
import struct
import sys
import time
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from sceneq_tools.chaos.decoder import Decoder, kind_of
from sceneq_tools.chaos.decoders import decoders
from sceneq_tools.chaos.mutation import Mutator

MIB = 1024 * 1024
EXAMPLES_KEPT = 3
NUMBER = struct.Struct("<Q")


class _Said(logging.Handler):
    """Puts log messages together, as a real handler would, and forgets them."""

    def emit(self, record: logging.LogRecord) -> None:
        record.getMessage()


def inputs(decoder: Decoder, count: int, seed: int) -> Iterable[bytes]:
    """Return the damaged inputs of a decoder, the same for the same seed."""
    mutator = Mutator(decoder.seeds, decoder.form, random.Random(f"{seed} {decoder.name}"))
    return (mutator.next() for _ in range(count))


def feed(decoder: Decoder, data: Iterable[bytes], number: Any = None) -> dict[str, Any]:
    """Return what became of ``data``: accepted, refused by kind, crashed, slowest, memory."""
    refused: Counter[str] = Counter()
    crashes: list[str] = []
    accepted = count = 0
    slowest_ms, slowest = 0.0, 0
    before_mb = reset_peak_mb()
    for count, one in enumerate(data, 1):
        if number is not None:
            NUMBER.pack_into(number, 0, count)
        began_s = time.thread_time()
        try:
            decoder.decode(one)
            accepted += 1
        except decoder.refusals as error:
            refused[kind_of(error)] += 1
        except Exception as error:
            crashes.append(f"input {count}: {type(error).__name__}: {error}"[:300])
        took_ms = 1000 * (time.thread_time() - began_s)
        if took_ms > slowest_ms:
            slowest_ms, slowest = took_ms, count
    return {
        "decoder": decoder.name,
        "inputs": count,
        "accepted": accepted,
        "refused": dict(refused.most_common()),
        "crashes": len(crashes),
        "crash_examples": crashes[:EXAMPLES_KEPT],
        "slowest_ms": round(slowest_ms, 1),
        "slowest_input": slowest,
        "peak_mb": round(max(0.0, peak_mb() - before_mb), 1),
    }


def limit_memory(limit_mb: int) -> None:
    """Let this process grow by so much and no more: what asks for more gets ``MemoryError``."""
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    limit = pages * resource.getpagesize() + limit_mb * MIB
    resource.setrlimit(resource.RLIMIT_AS, (limit, resource.RLIM_INFINITY))


def reset_peak_mb() -> float:
    """Begin a new peak where the system can; return the memory in use, MiB."""
    with contextlib.suppress(OSError):  # the peak of all decoders together is as high at least
        Path("/proc/self/clear_refs").write_text("5")
    return peak_mb()


def peak_mb() -> float:
    """Return the highest resident memory since the last reset, MiB."""
    lines = Path("/proc/self/status").read_text().splitlines()
    found = [int(line.split()[1]) for line in lines if line.startswith("VmHWM")]
    return found[0] / 1024 if found else 0.0


def main(arguments: list[str]) -> None:
    """Feed the decoders that are named."""
    count, seed, limit_mb = map(int, arguments[:3])
    folder, progress, names = Path(arguments[3]), Path(arguments[4]), arguments[5:]
    logging.basicConfig(level=logging.INFO, handlers=[_Said()])
    found = {decoder.name: decoder for decoder in decoders(folder)}
    if not names:
        print(json.dumps(list(found)))
        return
    limit_memory(limit_mb)
    with progress.open("r+b") as file, mmap.mmap(file.fileno(), NUMBER.size) as number:
        for name in names:
            NUMBER.pack_into(number, 0, 0)
            print(json.dumps(feed(found[name], inputs(found[name], count, seed), number)))
            sys.stdout.flush()
    os._exit(0)  # threads of nodes are of no more use


if __name__ == "__main__":
    main(sys.argv[1:])
