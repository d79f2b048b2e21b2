"""Somebody who types what the documents say, in a folder that has what they name.

Nothing that a reader sees is shortened. What a test cannot have (minutes, a robot, big recordings,
port 7447) is stood in for by files of the same name in this folder, or by a row of ``STAND_INS``.
"""

import glob
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import chdir, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

from typer.testing import CliRunner

from sceneq_tools.cli import app

from support.documents import ROOT

T = TypeVar("T")
PATIENCE_S = 110.0
POLL_S = 0.05
BIN = Path(sys.executable).parent

STAND_INS = {
    "SOURCE folder --step 10": ("room.r3d folder --step 10", "of a kind that has this parameter"),
    "<folder>": ("kitchen", "one recording for all pages"),
    "RECORDING...": ("kitchen", "one recording for all pages"),
    "../shared/data/house_rooms": ("kitchen", "one recording for all pages"),
    "house_rooms house_change": ("kitchen", "one recording for all pages"),
    "house_rooms": ("kitchen", "one recording for all pages"),
    "RECORDING": ("kitchen", "one recording for all pages"),
    "FOLDER": ("kitchen", "one recording for all pages"),
    "SOURCE": ("kitchen", "one recording for all pages"),
    "TRUTH": ("kitchen", "one recording for all pages"),
    "tools/sample": ("kitchen", "one recording for all pages"),
    "suite/test_kitchen_21": ("suite/test_kitchen_2", "two small rooms for eight"),
    " --test suite/test_living_room_21": ("", "two small rooms for eight"),
    "--test suite/test_mixed_21 --test suite/test_office_21": ("", "two small rooms for eight"),
    "--graph graph.yaml": ("--graph robot.yaml", "the graph of the other pages has no robot"),
    "docs/policies.png": ("policies.png", "the picture in the documents stays"),
    "query/house/": ("query/kitchen/", "one running graph for all pages"),
    "label/house/": ("label/kitchen/", "one running graph for all pages"),
    "teach/sample/": ("teach/kitchen/", "one running graph for all pages"),
    "--seek 10": ("--seek 0.1", "the recording is shorter"),
    "demo --live": ("demo --live --rate 2", "two processors have other tests to run as well"),
}
"""What a text of a command becomes, and why."""
ONLY = {
    "ros2:": ("ingest", "ingest is ready"),
    "--record": ("ingest", r"recorder +recording"),
    "--store": ("ingest,segmentation,mapping", r"ingest +(playing|finished)"),
    "": ("ingest", r"ingest +(playing|finished)"),
}
"""Of a graph that is started for what its source does: the nodes, and what is waited for.

The first key that stands in the command counts. All nodes together run in the other tests.
"""
OUTSIDE = ("sceneq replay", "sceneq chaos")
"""Commands of ours that end their process themselves, as nodes do, or have signals of their own."""
ASKS = r"sceneq (ask|status|view|teach|forget|export|replay|record|trace|metrics|sim) ?"
"""Commands with ``--connect``."""


@dataclass(frozen=True)
class Done:
    """What came of a command."""

    code: int
    printed: str


@dataclass
class Running:
    """A command that ends with Ctrl-C."""

    process: subprocess.Popen[bytes]
    log: Path

    def printed(self) -> str:
        return self.log.read_text() if self.log.exists() else ""

    def wait_for(self, pattern: str) -> re.Match[str]:
        """Return where it first printed ``pattern``; fail when it ends before, or never does."""
        deadline = time.monotonic() + PATIENCE_S
        while time.monotonic() < deadline:
            has_ended = self.process.poll() is not None
            if found := re.search(pattern, self.printed()):
                return found
            if has_ended:
                raise AssertionError(f"ended with {self.process.returncode}:\n{self.printed()}")
            time.sleep(POLL_S)
        raise AssertionError(f"no {pattern!r} in:\n{self.printed()}")

    def end(self) -> int:
        """Press Ctrl-C; return the exit code."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        try:
            return self.process.wait(PATIENCE_S)
        except subprocess.TimeoutExpired:
            os.killpg(self.process.pid, signal.SIGKILL)
            raise


@dataclass
class Reader:
    """Types commands in ``folder``; ``here`` are the addresses of what runs in this test."""

    folder: Path
    runtime: Path
    here: dict[str, str] = field(default_factory=dict)
    done: dict[str, Done] = field(default_factory=dict)
    started: set[str] = field(default_factory=set)
    patience_s: float = PATIENCE_S

    def read(self, text: str) -> str:
        """Return a command with its stand-ins."""
        for old, (new, _) in STAND_INS.items():
            text = text.replace(old, new)
        for old, new in self.here.items():
            text = text.replace(old, new)
        return text

    def types(self, text: str, *more: str) -> Done:
        """Run a command to its end: ours in this process, others in a shell."""
        text = self.read(text)
        if not text.startswith("sceneq ") or text.startswith(OUTSIDE):
            return self._in_a_shell(" ".join([text.partition("  #")[0], *more]))
        with chdir(self.folder):
            done = CliRunner().invoke(app, [*words(text)[1:], *more])
        failed = done.exception if not isinstance(done.exception, SystemExit) else None
        code = getattr(failed, "exit_code", done.exit_code)
        return Done(code, done.output + (f"{failed!r}" if failed else ""))

    def succeeds(self, text: str, *more: str) -> Done:
        """Type a command, beside the running graph if it asks one; fail if it does."""
        done = self.types(text, *self.beside(text), *more)
        assert done.code == 0, f"{self.read(text)}\nended with {done.code}:\n{done.printed}"
        return done

    def learns(self, text: str, told: str) -> str:
        """Type a command until it prints what is waited for; return that."""

        def said() -> str:
            found = re.search(told, self.types(text, *self.beside(text)).printed)
            return found[0] if found else ""

        return until(said)

    def has_done(self, text: str, *more: str) -> Done:
        """Return what came of a command that is the same with its stand-ins; type it once."""
        key = " ".join([self.read(text).partition("  #")[0].rstrip(), *more])
        if key not in self.done:
            self.done[key] = self.succeeds(text, *more)
        return self.done[key]

    def beside(self, text: str) -> list[str]:
        """Return where the router of this test is, for a command that does not say it."""
        router = self.here.get("tcp/127.0.0.1:7447")
        asks = re.match(ASKS, text) and "--from" not in text and "--connect" not in text
        return ["--connect", router] if router and asks else []

    def elsewhere(self, name: str, *linked: str) -> "Reader":
        """Return this person in a folder below, with addresses of its own.

        ``linked``: files and folders of here that are there too.
        """
        folder = self.folder / name
        if not folder.exists():
            folder.mkdir()
            for one in linked:
                (folder / one).symlink_to(self.folder / one)
        return Reader(folder, self.runtime)

    def runs_python(self, code: str) -> None:
        """Run a block of code in the folder."""
        with chdir(self.folder):
            exec(code, {})

    def makes(self, text: str) -> Done:
        """Let make say what it would do for a target of the repository."""
        return self._in_a_shell(f"cd {ROOT} && {text.replace('make', 'make -n', 1)}")

    def _in_a_shell(self, text: str) -> Done:
        done = subprocess.run(
            ["bash", "-c", text],
            cwd=self.folder,
            env=self.environment(),
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=self.patience_s,
            check=False,
        )
        return Done(done.returncode, done.stdout)

    @contextmanager
    def starts(self, text: str, *more: str, **variables: str) -> Iterator[Running]:
        """Start a command that goes on until Ctrl-C, and end it so; that has to succeed."""
        command = [*words(self.read(text)), *more]
        log = self.folder / f"printed-{time.monotonic_ns()}.log"
        with log.open("wb") as file:
            process = subprocess.Popen(
                [str(BIN / command[0]), *command[1:]],
                cwd=self.folder,
                env=self.environment() | variables,
                stdout=file,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )
        running = Running(process, log)
        try:
            yield running
        except BaseException:
            running.end()
            raise
        assert running.end() in (0, 130), running.printed()

    def environment(self) -> dict[str, str]:
        """Return that of a person in the virtual environment, with state of its own."""
        own = {"XDG_RUNTIME_DIR": str(self.runtime), "XDG_STATE_HOME": str(self.runtime)}
        return {**os.environ, **own, "PATH": f"{BIN}:{os.environ['PATH']}"}

    def clears(self, *names: str) -> None:
        """Remove what an earlier command wrote under the same name."""
        for name in names:
            path = self.folder / name
            shutil.rmtree(path) if path.is_dir() else path.unlink(missing_ok=True)


def until(what: Callable[[], T]) -> T:
    """Return the first true value of ``what``; what a graph knows comes in its own time."""
    deadline = time.monotonic() + PATIENCE_S
    while time.monotonic() < deadline:
        if value := what():
            return value
        time.sleep(POLL_S)
    raise TimeoutError(f"waited {PATIENCE_S} s")


def words(text: str) -> list[str]:
    """Return the words of a command as a shell makes them, with names of files filled in."""
    found: list[str] = []
    for word in shlex.split(text.replace("\\\n", " "), comments=True):
        found += sorted(glob.glob(word)) or [word]
    return found


def copy_examples(folder: Path) -> None:
    """Put docs/examples there; graphs get the encoder that needs no weights."""
    shutil.copytree(ROOT / "docs" / "examples", folder / "docs" / "examples")
    for graph in (folder / "docs" / "examples").glob("*.yaml"):
        graph.write_text(graph.read_text().replace("conse", "hash"))
