"""Processor, memory, clock and the optional furniture."""

import os
import shutil
import subprocess
import time
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

from sceneq_tools.doctor.finding import Finding, ok, warning
from sceneq_tools.doctor.libraries import as_root

GIB = 1024**3
CORES = 2
MEMORY_BYTES = 3 * GIB
"""A graph of eight processes and its map of a few rooms, with room to spare."""
FIRST_YEAR, LAST_YEAR = 2025, 2100
"""A clock outside of these was never set."""
RESOLUTION_S = 1e-5
"""Latencies are differences of the monotonic clock, the shortest a few tenths of a millisecond."""
TIMEDATECTL_S = 2.0
FURNITURE = Path("/usr/share/sweethome3d/furniture")
FURNITURE_VARIABLE = "SCENEQ_FURNITURE_DIR"
"""As in ``room.libraries``, which takes long to import."""
FURNITURE_PACKAGE = "sweethome3d-furniture"


def cores(count: int | None = None) -> Finding:
    """Count the cores this process may use."""
    usable = count or len(os.sched_getaffinity(0))
    if usable >= CORES:
        return ok(f"{usable}")
    return warning(f"{usable}: a graph will not keep up with a camera", "sceneq up --rate 5")


def memory(meminfo: Path = Path("/proc/meminfo"), limit: Path | None = None) -> Finding:
    """Compare free memory, and the limit of a container, with what a graph takes."""
    available = min(_available_bytes(meminfo), _limit_bytes(limit))
    said = f"{available / GIB:.1f} GiB available"
    if available >= MEMORY_BYTES:
        return ok(said)
    return warning(f"{said}, a graph takes up to {MEMORY_BYTES / GIB:.0f}", "ps aux --sort=-rss")


def clock(
    now: Callable[[], float] = time.time,
    resolution_s: float = time.get_clock_info("monotonic").resolution,
    synchronised: Callable[[], bool | None] | None = None,
) -> Finding:
    """Check the date, the resolution of the monotonic clock and the synchronisation."""
    moment = datetime.fromtimestamp(now(), UTC)
    said = f"{moment:%Y-%m-%d %H:%M} UTC"
    mend = as_root("timedatectl set-ntp true")
    if not FIRST_YEAR <= moment.year <= LAST_YEAR:
        return warning(f"{said} cannot be: stamps will be wrong", mend)
    if resolution_s > RESOLUTION_S:
        return warning(f"{said}, resolution {resolution_s:g} s: latencies are coarse", mend)
    synced = (synchronised or ntp_synchronised)()
    if synced is False:
        return warning(f"{said}, not synchronised: stamps of other machines will not fit", mend)
    return ok(said + (", synchronised" if synced else ""))


def ntp_synchronised() -> bool | None:
    """Return whether NTP sets this clock; None = nobody here can tell."""
    program = shutil.which("timedatectl")
    if program is None:
        return None
    command = [program, "show", "--property=NTPSynchronized", "--value"]
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=TIMEDATECTL_S, check=False
        )
    except (OSError, subprocess.TimeoutExpired):
        return None
    return {"yes": True, "no": False}.get(done.stdout.strip())


def furniture(folder: Path | None = None) -> Finding:
    """Say whether the models for realistic rooms are installed; nothing else needs them."""
    folder = folder or Path(os.environ.get(FURNITURE_VARIABLE) or FURNITURE)
    libraries = sorted(folder.glob("*.sh3f")) if folder.is_dir() else []
    if libraries:
        return ok(f"{len(libraries)} libraries of models in {folder}")
    mend = as_root(f"apt-get install {FURNITURE_PACKAGE}")
    return ok("not installed (optional: makes the rooms of `sceneq synth` realistic)", mend)


def _available_bytes(meminfo: Path) -> int:
    for line in meminfo.read_text().splitlines():
        if line.startswith("MemAvailable:"):
            return int(line.split()[1]) * 1024
    raise ValueError(f"{meminfo}: no line MemAvailable")


def _limit_bytes(limit: Path | None) -> float:
    """Return what a container may take; most machines set no limit."""
    path = limit or Path("/sys/fs/cgroup/memory.max")
    try:
        text = path.read_text().strip()
    except OSError:
        return float("inf")
    return float("inf") if text == "max" else int(text)
