"""Durable files that are torn, changed, of a later version, or on a disk that takes nothing."""

import os
import random
import shutil
import signal
import sqlite3
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from sceneq_tools.chaos.known import SCENE, VIEWS_ANEW, Known, live, settled, undisturbed
from sceneq_tools.chaos.live_graph import LiveGraph
from sceneq_tools.chaos.scenario import NOTHING, Outcome, Plan, skipped

NEWER = 99
WRITING_S = 4.0
BALLAST_MB, ROOM_MB = 60, 2
JOURNAL, VIEWS, FEATURES = "map/journal.sqlite", "views.sqlite", "features-*.sqlite"
NAMES, CHECKPOINTS = "names.jsonl", "map/checkpoint-*.sceneq"
TOLD = "map/told.sqlite"
Damage = Callable[[Path, random.Random], None]


def damaged(plan: Plan) -> Iterator[Outcome]:
    """Files that are torn or changed: set aside, the one before used, nothing lost."""
    whole, store = undisturbed(plan), kept_store(plan)
    for number, (fault, damages) in enumerate(_DAMAGES.items()):
        if plan.short and number >= 2:
            return
        copy = plan.work / str(number)
        shutil.copytree(store, copy)
        (copy / SCENE / NAMES).touch()
        chance = random.Random(f"{plan.seed} {fault}")
        for pattern, damage in damages.items():
            for path in sorted((copy / SCENE).glob(pattern))[-1:]:
                damage(path, chance)
        with live(plan, "--store", str(copy)) as graph:
            lost = _lost(settled(graph), whole, views_anew=bool({VIEWS, JOURNAL} & damages.keys()))
        aside = sorted(path.name for path in copy.rglob("*.corrupt*"))
        detail = f"set aside: {', '.join(aside) or 'nothing'}"
        yield Outcome(fault, 1, lost, lost in (NOTHING, VIEWS_ANEW), detail)


def newer(plan: Plan) -> Iterator[Outcome]:
    """A store of a later version: told, the graph runs in memory, not a byte is changed."""
    copy = plan.work / "newer"
    shutil.copytree(kept_store(plan), copy)
    for pattern in (JOURNAL, TOLD, VIEWS, FEATURES):
        for path in (copy / SCENE).glob(pattern):
            with sqlite3.connect(path) as database:
                database.execute(f"PRAGMA user_version = {NEWER}")
            database.close()
    yield _untouched(plan, "store of a newer version", copy)


def read_only(plan: Plan) -> Iterator[Outcome]:
    """A disk that cannot be written: the graph runs in memory."""
    copy = plan.work / "read-only"
    shutil.copytree(kept_store(plan), copy)
    mount = 'mount --bind "$0" "$0" && mount -o remount,ro,bind "$0" && exec "$@"'
    if reason := not_permitted(mount, copy):
        yield skipped("read-only disk", reason)
        return
    yield _untouched(plan, "read-only disk", copy, within=within(mount, copy))


def full(plan: Plan) -> Iterator[Outcome]:
    """A disk without room: the map lives on; with room again, the next start has all of it."""
    disk = plan.work / "disk"
    disk.mkdir()
    size = f"size={BALLAST_MB + ROOM_MB}m"
    mount = f'mount -t tmpfs -o {size} tmpfs "$0" && head -c {BALLAST_MB}M /dev/zero > "$0/ballast"'
    mount += ' && exec "$@"'
    if reason := not_permitted(mount, disk):
        yield skipped("disk full", reason)
        return
    whole = undisturbed(plan)
    with live(plan, "--store", str(disk), within=within(mount, disk)) as graph:
        lost = settled(graph).lost(whole)
        failed = sum(node.counters.get("store_failed", 0) for node in graph.heard().values())
        inside = Path(f"/proc/{graph.process.pid}/root") / disk.relative_to("/")
        shutil.copytree(inside / SCENE, plan.work / "freed" / SCENE)
    yield Outcome("disk full", 1, lost, lost == NOTHING and failed > 0, f"{failed} failed writes")
    with live(plan, "--store", str(plan.work / "freed")) as graph:
        lost = _lost(settled(graph), whole, views_anew=True)
    fine = lost in (NOTHING, VIEWS_ANEW) and verified(plan.work / "freed")
    yield Outcome("started again after a full disk", 1, lost, fine, "every file verified")


def torn_writes(plan: Plan) -> Iterator[Outcome]:
    """Kill -9 of mapping while it writes a checkpoint."""
    whole, caught = undisturbed(plan), 0
    losses: set[str] = set()
    for number in range(plan.pick(3, 1)):
        store = plan.work / f"torn-{number}"
        with live(plan, "--store", str(store)) as graph:
            graph.wait_until_begun()
            caught += _kill_while_writing(graph, store)
            losses.add(settled(graph).lost(whole))
    lost = "; ".join(sorted(losses - {NOTHING})) or NOTHING
    yield Outcome("kill -9 while a checkpoint is written", caught, lost, lost == NOTHING)


def kept_store(plan: Plan) -> Path:
    """Return the store of an undisturbed run, to be copied; made by the first who asks."""
    store = plan.together / "store"
    if not store.exists():
        with live(plan, "--store", str(store)) as graph:
            settled(graph)
    return store


def verified(store: Path) -> bool:
    """Tell whether every byte of a scene can be read."""
    command = [
        sys.executable,
        "-m",
        "sceneq_tools",
        "scene",
        "verify",
        SCENE,
        "--store",
        str(store),
    ]
    return subprocess.run(command, capture_output=True, check=False).returncode == 0


def within(mount: str, folder: Path) -> tuple[str, ...]:
    """Return the command that runs another one where ``folder`` is mounted so."""
    return ("unshare", "-rm", "sh", "-c", mount, str(folder))


def not_permitted(mount: str, folder: Path) -> str:
    """Return why this machine does not let us mount, '' when it does."""
    try:
        command = (*within(mount, folder), "true")
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    except OSError as error:
        return f"unshare: {error.strerror}"
    return done.stderr.strip().splitlines()[0] if done.returncode else ""


def _untouched(plan: Plan, fault: str, store: Path, **more: Any) -> Outcome:
    whole, before = undisturbed(plan), _bytes_of(store)
    with live(plan, "--store", str(store), **more) as graph:
        lost = _lost(settled(graph), whole, views_anew=True)
        failed = sum(node.counters.get("store_failed", 0) for node in graph.heard().values())
    changed = [name for name, data in _bytes_of(store).items() if before.get(name) != data]
    same = not (changed or before.keys() - _bytes_of(store).keys())
    detail = f"{failed} stores left alone" + ("" if same else f", changed: {', '.join(changed)}")
    fine = lost in (NOTHING, VIEWS_ANEW) and same and failed > 0
    return Outcome(fault, 1, lost, fine, detail)


def _lost(now: Known, whole: Known, *, views_anew: bool) -> str:
    """Return what is lost; ``views_anew``: what was on the disk could not serve the views."""
    lost = now.lost(whole)
    return now.lost_but_views(whole) if lost != NOTHING and views_anew else lost


def _bytes_of(store: Path) -> dict[str, bytes]:
    """Return what counts: locks and what SQLite keeps beside a file in use do not."""
    files = (path for path in sorted(store.rglob("*")) if path.is_file())
    beside = ("lock", "-wal", "-shm")
    return {str(p.relative_to(store)): p.read_bytes() for p in files if not p.name.endswith(beside)}


def _kill_while_writing(graph: LiveGraph, store: Path) -> int:
    deadline_s = time.monotonic() + WRITING_S
    while time.monotonic() < deadline_s:
        if any((store / SCENE / "map").glob("*.unfinished")):
            os.kill(graph.pids()["mapping"], signal.SIGKILL)
            return 1
    return 0


def _torn(path: Path, chance: random.Random) -> None:
    os.truncate(path, chance.randrange(1, path.stat().st_size))


def _changed(path: Path, chance: random.Random) -> None:
    """Change a byte in a hundred of the second half."""
    data = bytearray(path.read_bytes())
    for at in chance.sample(range(len(data) // 2, len(data)), max(1, len(data) // 200)):
        data[at] ^= 0xFF
    path.write_bytes(data)


def _emptied(path: Path, chance: random.Random) -> None:
    path.write_bytes(bytes(path.stat().st_size))


def _halved(path: Path, chance: random.Random) -> None:
    """Leave half of a line behind."""
    path.write_bytes(b'{"op": "teach", "num')


_DAMAGES: Mapping[str, Mapping[str, Damage]] = {
    "newest checkpoint torn, a byte of the views changed": {CHECKPOINTS: _torn, VIEWS: _changed},
    "newest checkpoint changed, descriptors torn, names torn, what was told torn": {
        CHECKPOINTS: _changed,
        TOLD: _torn,
        FEATURES: _torn,
        NAMES: _halved,
    },
    "journal torn": {JOURNAL: _torn},
    "journal changed, views torn": {JOURNAL: _changed, VIEWS: _torn},
    "all of them overwritten with zeros": {
        JOURNAL: _emptied,
        TOLD: _emptied,
        VIEWS: _emptied,
        FEATURES: _emptied,
        CHECKPOINTS: _emptied,
    },
}
