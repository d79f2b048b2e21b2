"""Where the processor time of a keyframe goes, over a whole recording.

What others do on this machine meanwhile does not count, nor does waiting.
"""

import resource
import time
from collections.abc import Iterator
from pathlib import Path

from sceneq_tools.bench.measurement import Measurement, Options, median
from sceneq_tools.bench.recording import open_batch, play
from sceneq_tools.bench.reference import NAME, fixed_work_ms
from sceneq_tools.bench.stopwatch import Stopwatch

NODES = {
    "ingest": "sceneq_nodes.ingest:Ingest.step",
    "segmentation": "sceneq_nodes.segmentation:Segmentation.step",
    "mapping": "sceneq_nodes.mapping:Mapping.step",
    "views": "sceneq_nodes.views:Views.step",
    "encoding": "sceneq_nodes.encoding:Encoding.step",
    "routing": "sceneq_nodes.routing:Routing.step",
}
PARTS = {
    "ingest: decode colour": "sceneq_nodes._recorded_source:decode_rgb",
    "ingest: decode depth": "sceneq_nodes._recorded_source:decode_depth_mm",
    "mapping: surface": "sceneq_core.mapping.mapper:measure_surface",
    "mapping: voxels": "sceneq_core.mapping.voxels:Voxels.integrate",
    "mapping: free space": "sceneq_core.mapping.mapper:find_seen_through",
    "mapping: superpoints": "sceneq_core.mapping.superpoints:Superpoints.update",
    "mapping: association": "sceneq_core.mapping.association:Association.update",
    "mapping: instances": "sceneq_core.mapping.registry:Registry.update",
}
PIPELINE = ("segmentation", "mapping", "views")
CORES = 2
"""What the pipeline is to keep up on; others have more."""
KEYFRAME = "one keyframe"
KEYFRAMES = {KEYFRAME: "sceneq_core.mapping.mapper:Mapper.integrate"}
MIB_KIB = 1024


def stages(options: Options) -> Iterator[Measurement]:
    """Run the recording and tell what each node, and each step of mapping, took a keyframe."""
    memory_mib: list[float] = []

    def measure_memory(stage: str) -> None:
        if stage == KEYFRAME:
            memory_mib.append(held_mib())

    stopwatch = Stopwatch(measure_memory, clock=time.process_time)
    before_ms = fixed_work_ms()
    with stopwatch.watching({**NODES, **PARTS, **KEYFRAMES}):
        batch = open_batch(options)
        try:
            start_s = time.process_time()
            frames = play(batch, options)
            took_s = time.process_time() - start_s
        finally:
            batch.close()
    # The mean of before and after: a machine that others use changes meanwhile.
    reference_ms = (before_ms + fixed_work_ms()) / 2
    integrated_ms = stopwatch.taken_ms[KEYFRAME]
    keyframes = max(len(integrated_ms), 1)
    for stage in (*NODES, *PARTS):
        per_keyframe_ms = sum(stopwatch.taken_ms[stage]) / keyframes
        yield Measurement(stage, per_keyframe_ms, "ms a keyframe", NAME, reference_ms)
    per_s = 1000 / reference_ms
    taken_ms = [sum(stopwatch.taken_ms[stage]) / keyframes for stage in PIPELINE]
    yield Measurement(", ".join(PIPELINE), pipelined(taken_ms), "keyframes/s", NAME, per_s)
    yield Measurement("end to end", keyframes / took_s, "keyframes/s", NAME, per_s)
    yield Measurement("end to end", frames / took_s, "frames/s", NAME, per_s)
    yield from growth(integrated_ms)
    yield Measurement("memory at most", _peak_mib(), "MiB", series=tuple(memory_mib))


def pipelined(taken_ms: list[float]) -> float:
    """Return how many keyframes a second stages get through, a process each, on ``CORES``."""
    return 1000 / max(max(taken_ms), sum(taken_ms) / CORES)


def growth(integrated_ms: list[float]) -> Iterator[Measurement]:
    """Compare the last third of the keyframes with the first, if there are enough."""
    third = len(integrated_ms) // 3
    if third:
        early_ms, late_ms = median(integrated_ms[:third]), median(integrated_ms[-third:])
        beside, series = "its first third", tuple(integrated_ms)
        yield Measurement("mapping, last third", late_ms, "ms", beside, early_ms, series)


def held_mib() -> float:
    """Return what this process holds now."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * resource.getpagesize() / 2**20


def _peak_mib() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / MIB_KIB
