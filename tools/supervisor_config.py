"""``supervisord.conf`` of one machine's part of a graph.

supervisord restarts what dies: at once after it ran for ``START_S`` seconds, else with a growing
pause and at most ``max_restarts`` times. Exit code 2 (bad parameters) is never restarted.
"""

import shlex
import sys
from pathlib import Path

from sceneq_tools.graph import ROUTER, GraphNode

START_S = 5
"""A crash sooner than this counts as a failed start; longer than loading any model takes."""
STOP_S = 2
"""Nodes end within one second of SIGTERM; twice that and they are killed."""
LOG_BYTES = 5 * 1024 * 1024
OLD_LOGS = 2
MANY = 1_000_000
"""Failed starts of the router: without it nothing works, so it is never given up."""
NODES = "nodes"
RESTART = {"on-failure": "unexpected", "always": "true", "never": "false"}

_HEAD = """\
[supervisord]
nodaemon=true
silent=true
identifier=sceneq
directory={directory}
logfile={logs}/supervisord.log
logfile_maxbytes={log_bytes}
logfile_backups=1
pidfile={folder}/supervisord.pid
childlogdir={folder}

[unix_http_server]
file={folder}/supervisor.sock
chmod=0700

[rpcinterface:supervisor]
supervisor.rpcinterface_factory = supervisor.rpcinterface:make_main_rpcinterface
"""

_GROUP = """\

[group:{group}]
programs={programs}
priority=20
"""

_PROGRAM = """\

[program:{name}]
command={command}
environment=SCENEQ_NODE="{name}"
priority=10
autorestart={autorestart}
exitcodes=0,2
startsecs={start_s}
startretries={retries}
stopwaitsecs={stop_s}
stopasgroup=true
killasgroup=true
redirect_stderr=true
stdout_logfile={logs}/{name}.log
stdout_logfile_maxbytes={log_bytes}
stdout_logfile_backups={old_logs}
"""


def render(nodes: tuple[GraphNode, ...], folder: Path, logs: Path) -> str:
    """Return the configuration: the router first, the nodes as one group that stops together."""
    head = _HEAD.format(
        directory=_plain(Path.cwd()),
        folder=_plain(folder),
        logs=_plain(logs),
        log_bytes=LOG_BYTES,
    )
    router = _program(ROUTER, ("sceneq_nodes", ROUTER), "true", MANY, logs)
    names = ",".join(node.id for node in nodes)
    group = _GROUP.format(group=NODES, programs=names) if nodes else ""
    return head + group + router + "".join(_node_program(node, logs) for node in nodes)


def _node_program(node: GraphNode, logs: Path) -> str:
    policy = RESTART[node.restart_policy]
    retries = 0 if node.restart_policy == "never" else node.max_restarts
    return _program(node.id, ("sceneq_nodes",), policy, retries, logs)


def _program(name: str, module: tuple[str, ...], autorestart: str, retries: int, logs: Path) -> str:
    command = shlex.join([sys.executable, "-P", "-m", *module])
    return _PROGRAM.format(
        name=name,
        command=_plain(command),
        autorestart=autorestart,
        retries=retries,
        logs=_plain(logs),
        start_s=START_S,
        stop_s=STOP_S,
        log_bytes=LOG_BYTES,
        old_logs=OLD_LOGS,
    )


def _plain(text: str | Path) -> str:
    """supervisord expands ``%(name)s``."""
    return str(text).replace("%", "%%")
