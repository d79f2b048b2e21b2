"""Where Scene-Q writes: disk space, permission, shared memory, and the encoder's files."""

import os
import shlex
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from sceneq_tools.doctor.finding import Finding, ok, problem, warning
from sceneq_tools.doctor.libraries import as_root

MIB, GB = 1024**2, 10**9
SHARED_MEMORY = Path("/dev/shm")
SHARED_MEMORY_BYTES = 256 * MIB
"""Four publishing processes with the 64 MiB that each sets aside; the link takes what is over."""
DISK_BYTES = 2 * GB
DISK_LEAST_BYTES = GB // 2
CONTAINER = Path("/.dockerenv")
PREPARE = "-m sceneq_nodes._assets"


def written_folders() -> list[Path]:
    """Return where commands write when they are not told otherwise."""
    home = Path.home()
    cache = os.environ.get("XDG_CACHE_HOME") or home / ".cache"
    state = os.environ.get("XDG_STATE_HOME") or home / ".local" / "state"
    return [Path("out").resolve(), Path(cache) / "sceneq", Path(state) / "sceneq"]


def disk(
    folders: Sequence[Path] | None = None, free: Callable[[Path], int] | None = None
) -> Finding:
    """Look for the fullest of the disks that are written to."""
    free = free or (lambda folder: shutil.disk_usage(folder).free)
    existing = [_existing(folder) for folder in folders or written_folders()]
    free_bytes, fullest = min((free(folder), folder) for folder in existing)
    said = f"{free_bytes / GB:.1f} GB free at {fullest}"
    if free_bytes >= DISK_BYTES:
        return ok(said)
    mend = f"du -xh {shlex.quote(str(fullest))} | sort -h | tail"
    return (warning if free_bytes >= DISK_LEAST_BYTES else problem)(said, mend)


def writable(folders: Sequence[Path] | None = None) -> Finding:
    """Write a file where commands will write."""
    wanted = folders or written_folders()
    refused = [refusal for folder in wanted if (refusal := _refused(folder))]
    if not refused:
        return ok(", ".join(str(folder) for folder in wanted))
    path, reason = refused[0]
    mend = f"sudo chown -R {os.geteuid()} {shlex.quote(str(path))}"
    return problem(f"{path}: {reason}", mend)


def shared_memory(
    folder: Path = SHARED_MEMORY,
    size: Callable[[Path], tuple[int, int]] | None = None,
    container: bool | None = None,
) -> Finding:
    """Check that frames can go from process to process without being copied."""
    if not folder.is_dir():
        return warning(f"no {folder}: frames go over the link", as_root(f"mkdir -m 1777 {folder}"))
    total, free = (size or _size)(folder)
    said = f"{free / MIB:.0f} of {total / MIB:.0f} MiB free in {folder}"
    if free >= SHARED_MEMORY_BYTES:
        return ok(said)
    mend = as_root(f"mount -o remount,size=1G {folder}")
    inside = CONTAINER.exists() if container is None else container
    return warning(f"{said}: frames go over the link", _of_container(mend) if inside else mend)


def leftovers(folder: Path = SHARED_MEMORY, used: Callable[[], set[str]] | None = None) -> Finding:
    """Look for shared memory of processes that were killed."""
    if not folder.is_dir():
        return ok("none")
    in_use = (used or mapped_files)()
    # Whether those of others are in use, only root can see.
    ours = [path for path in sorted(folder.glob("*.zenoh")) if _is_ours(path)]
    left = [path for path in ours if str(path) not in in_use]
    if not left:
        return ok("none")
    size_mib = sum(map(_held_bytes, left)) / MIB
    said = f"{len(left)} files of killed processes hold {size_mib:.0f} MiB in {folder}"
    return warning(said, shlex.join(["rm", *map(str, left)]))


def encoder_files() -> Finding:
    """Check the weights that set-up prepares for the default encoder."""
    from sceneq_nodes import _assets

    return encoder_finding(_assets.prepared_folder(), _assets.damaged)


def encoder_finding(folder: Path, damaged: Callable[[Path], list[str]]) -> Finding:
    """Say whether ``folder`` holds the encoder's files, unchanged since they were made."""
    prepare = f"{sys.executable} {PREPARE}"
    if not folder.is_dir():
        return warning("not prepared: the first use takes 20 s longer", prepare)
    if bad := damaged(folder):
        mend = f"rm -r {shlex.quote(str(folder))} && {prepare}"
        return problem(f"damaged in {folder}: {', '.join(bad)}", mend)
    return ok(f"prepared and unchanged in {folder}")


def mapped_files(processes: Path = Path("/proc")) -> set[str]:
    """Return the files in shared memory that a process we may look at has mapped."""
    maps = (_read(process / "maps") for process in processes.glob("[0-9]*"))
    prefix = f"{SHARED_MEMORY}/"
    lines: Iterable[str] = (line for text in maps for line in text.splitlines())
    return {line[line.index(prefix) :] for line in lines if prefix in line}


def _read(path: Path) -> str:
    """Return the text; '' of a process that has ended meanwhile or belongs to somebody else."""
    try:
        return path.read_text(errors="replace")
    except OSError:
        return ""


def _held_bytes(path: Path) -> int:
    """Return what a file really takes; nothing when it was removed meanwhile."""
    try:
        return path.stat().st_blocks * 512
    except FileNotFoundError:
        return 0


def _is_ours(path: Path) -> bool:
    try:
        return os.geteuid() in (0, path.stat().st_uid)
    except FileNotFoundError:
        return False


def _existing(folder: Path) -> Path:
    """Return the folder, or the nearest one above that is there."""
    return next(path for path in (folder, *folder.parents) if path.is_dir())


def _refused(folder: Path) -> tuple[Path, str] | None:
    place = _existing(folder)
    try:
        with tempfile.TemporaryFile(dir=place):
            return None
    except OSError as error:
        return place, (error.strerror or str(error)).lower()


def _size(folder: Path) -> tuple[int, int]:
    usage = shutil.disk_usage(folder)
    return usage.total, usage.free


def _of_container(_: str) -> str:
    return "docker run --shm-size=1g ..."
