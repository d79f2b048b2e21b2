"""Run one machine's part of a graph until it is told to stop, and say what happens."""

import json
import os
import tempfile
import threading
import time
from collections.abc import Mapping
from pathlib import Path

from sceneq_nodes._credentials import VARIABLE, Credentials
from sceneq_nodes._logs import TEXT
from sceneq_nodes._logs import VARIABLE as LOG_FORM
from sceneq_tools.console import Console
from sceneq_tools.errors import UserError
from sceneq_tools.graph import DEFAULT_ENDPOINT, ROUTER
from sceneq_tools.graph_plan import Plan
from sceneq_tools.heartbeats import Heartbeat, Heartbeats
from sceneq_tools.log_tail import LogTail, last_line
from sceneq_tools.story import Exit, change, exit_in
from sceneq_tools.supervision import EXITED, FATAL, STOPPED, Process, Supervisor
from sceneq_tools.supervisor_config import render
from sceneq_tools.troubles import TROUBLE, Troubles
from sceneq_tools.watchdog import Watchdog

TICK_S = 0.2
BAD_PARAMETERS = 2
KILLED = "SIGKILL"


class Launcher:
    """Starts the processes of a plan, watches them, forwards their warnings.

    Args:
        plan: what to run.
        logs: folder of one log file per process.
        console: where events go.
    """

    def __init__(self, plan: Plan, logs: Path, console: Console) -> None:
        self._plan = plan
        self._logs = logs
        self._console = console
        self._watchdog = Watchdog(plan.watchdog)
        self._credentials = node_credentials(plan.secure)
        if plan.secure is not None:
            need_ros_passage(plan)
        self._heartbeats = Heartbeats(plan.endpoint, self._credentials)
        self._before: dict[str, Process] = {}
        self._ready: set[str] = set()
        self._were_ready: set[str] = set()
        names = (ROUTER, *(node.id for node in plan.nodes))
        self._troubles = Troubles(logs, names, console)
        self._reports = LogTail(logs / "supervisord.log")
        self._doing: dict[str, str] = {}
        self._exits: dict[str, int] = {}
        self._refused: set[str] = set()
        self._mortal = {node.id for node in plan.nodes if node.restart_policy == "never"}
        self._started_s = time.monotonic()

    def run(self, stop: threading.Event) -> int:
        """Return the exit code: 0 stopped or finished, 1 broken, 2 a node refused its parameters.

        Raises:
            UserError: the logs cannot be written, or nothing starts.
        """
        supervisor = self._prepare()
        self._console.say("up", self._headline())
        try:
            supervisor.start()
            return self._watch(supervisor, stop)
        finally:
            self._heartbeats.close()
            supervisor.stop()
            self._troubles.forward()
            self._troubles.close()
            self._reports.close()
            self._console.say("up", f"stopped, logs in {self._logs}")

    def _prepare(self) -> Supervisor:
        try:
            self._logs.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise UserError(f"{self._logs}: {error.strerror} (say --log-dir FOLDER)") from error
        folder = run_folder(self._plan.scene)
        graph = folder / "graph.json"
        graph.write_text(json.dumps(self._plan.as_json(), indent=2))
        conf = render(self._plan.nodes, folder, self._logs.resolve())
        (folder / "supervisord.conf").write_text(conf)
        environment = {"SCENEQ_GRAPH": str(graph)}
        if self._plan.log != TEXT:
            environment[LOG_FORM] = self._plan.log
        if self._credentials is not None:
            environment[VARIABLE] = str(self._credentials.folder)
        return Supervisor(folder, environment)

    def _headline(self) -> str:
        names = " ".join(node.id for node in self._plan.nodes)
        return f"scene {self._plan.scene} on {self._plan.endpoint}: {names}"

    def _watch(self, supervisor: Supervisor, stop: threading.Event) -> int:
        while not stop.wait(TICK_S):
            if not supervisor.alive():
                self._console.say("up", "supervisord died: stopping everything", "bad")
                return 1
            processes = supervisor.processes()
            self._troubles.forward()
            if self._tell_exits(supervisor, {process.name: process for process in processes}):
                processes = supervisor.processes()
            for process in processes:
                self._follow(process)
            if (code := self._over(processes)) is not None:
                return code
            for beat in self._heartbeats.drain():
                self._hear(beat)
            self._kill_hung(supervisor)
        return 0

    def _follow(self, process: Process) -> None:
        before = self._before.get(process.name)
        self._before[process.name] = process
        if before is not None and before.pid != process.pid:
            self._unwatch(process.name)
        if (news := change(before, process)) is not None:
            self._console.say(process.name, *news)

    def _tell_exits(self, supervisor: Supervisor, processes: Mapping[str, Process]) -> bool:
        """Tell what has ended; return whether something of it was started again here."""
        revived = False
        for line in self._reports.new_lines():
            if (end := exit_in(line)) is None:
                continue
            self._exits[end.name] = end.code
            words = self._last_words(end)
            self._console.say(end.name, f"{end}{words}", "bad" if end.code else "")
            if (process := processes.get(end.name)) is None:
                continue
            if end.code == BAD_PARAMETERS:
                supervisor.hold(process)
                self._refused.add(end.name)
            elif end.signal == KILLED and self._was_fine(end.name):
                supervisor.revive(process)
                revived = True
        return revived

    def _was_fine(self, name: str) -> bool:
        """A node that was ready did not fail to start; the router is when a node is."""
        if name == ROUTER:
            return bool(self._ready)
        return name in self._ready and name not in self._mortal

    def _last_words(self, end: Exit) -> str:
        if end.code <= 0:
            return ""
        words = last_line(self._logs / f"{end.name}.log")
        told = TROUBLE.search(words) or words.startswith("{")  # by its record, if it is trouble
        return f": {words}" if words and not told else ""

    def _unwatch(self, name: str) -> None:
        self._ready.discard(name)
        if name == ROUTER:
            self._watchdog.forgive(time.monotonic())
        self._watchdog.forget(name)

    def _over(self, processes: list[Process]) -> int | None:
        """Return the exit code when there is nothing left to watch, ``None`` as long as there is.

        A node that refuses its parameters at its first start means that the graph is wrong.
        """
        if self._refused - self._were_ready:
            return BAD_PARAMETERS
        if not processes or any(not self._ended(process) for process in processes):
            return None
        return int(any(self._exits.get(node.id) for node in self._plan.nodes))

    def _ended(self, process: Process) -> bool:
        if process.name == ROUTER:
            return bool(self._plan.nodes)  # it ends with them, unless it was asked for alone
        held = process.state == STOPPED and process.name in self._refused
        return held or process.state in (EXITED, FATAL)

    def _hear(self, beat: Heartbeat) -> None:
        process = self._before.get(beat.node)
        if process is None or beat.pid != process.pid:
            return  # the last words of a process that is gone, or another machine's node
        if beat.ready:
            self._watchdog.beat(beat.node, time.monotonic(), beat.busy_s)
            self._note_ready(beat.node)
        if beat.doing != self._doing.get(beat.node, ""):
            self._doing[beat.node] = beat.doing
            if beat.doing:
                self._console.say(beat.node, beat.doing)

    def _note_ready(self, name: str) -> None:
        if name in self._ready or name == ROUTER:
            return
        self._ready.add(name)
        everybody = {node.id for node in self._plan.nodes}
        if self._ready == everybody and not everybody <= self._were_ready:
            took = time.monotonic() - self._started_s
            who = f"all {len(everybody)} nodes are" if len(everybody) > 1 else f"{name} is"
            self._console.say("up", f"{who} ready after {took:.1f} s", "good")
            self._invite()
        elif name in self._were_ready:
            self._console.say(name, "ready again", "good")
        self._were_ready.add(name)

    def _invite(self) -> None:
        if any(node.node_kind == "routing" for node in self._plan.nodes):
            elsewhere = self._plan.endpoint != DEFAULT_ENDPOINT
            where = f" --connect {self._plan.endpoint}" if elsewhere else ""
            self._console.say("up", f'from another shell: sceneq ask "red mug"{where}')

    def _kill_hung(self, supervisor: Supervisor) -> None:
        for name, reason in self._watchdog.hung(time.monotonic()).items():
            self._watchdog.forget(name)
            if (process := self._before.get(name)) and process.pid:
                self._console.say(name, f"hangs ({reason}): killed", "bad")
                supervisor.kill(process)


def run_folder(scene: str) -> Path:
    """Make a new private folder with a short name: a socket's path has to fit in 107 bytes."""
    parent = os.environ.get("XDG_RUNTIME_DIR")
    usable = parent and os.access(parent, os.W_OK) and len(parent) < 50
    return Path(tempfile.mkdtemp(prefix=f"sceneq-{scene[:20]}-", dir=parent if usable else None))


def default_logs(scene: str) -> Path:
    """Return where logs of a scene are kept (XDG base directory specification)."""
    state = os.environ.get("XDG_STATE_HOME") or str(Path.home() / ".local" / "state")
    return Path(state) / "sceneq" / scene


def node_credentials(secure: Path | None) -> Credentials | None:
    """Return what the nodes of this machine show: those of a robot, else of a server.

    Raises:
        UserError: there are none, or they cannot be used.
    """
    if secure is None:
        return None
    role = "robot" if (secure / "robot").is_dir() else "server"
    try:
        Credentials(secure / ROUTER).access()
        return Credentials(secure / role)
    except ValueError as error:
        raise UserError(f"{error} (sceneq secure init {secure})", 2) from error


def need_ros_passage(plan: Plan) -> None:
    """Raise ``UserError`` when this machine's router would deny ROS topics that its nodes name."""
    from sceneq_tools.security.ros_keys import denied, keys_of

    if plan.secure is None:
        return
    keys = keys_of((node.node_kind, node.params) for node in plan.nodes)
    if stopped := denied(Credentials(plan.secure / ROUTER).access(), keys):
        hint = f"sceneq secure init {plan.secure} --graph graph.yaml"
        raise UserError(f"the access rules let no {stopped[0]} pass ({hint})", 2)
