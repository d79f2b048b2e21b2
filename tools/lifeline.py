"""``supervisord`` on a lifeline: it stops everything when its standard input ends.

The launcher holds the other end of that pipe and nobody else does, so the end comes even when the
launcher is killed with -9. Run as ``python -m sceneq_tools.lifeline FOLDER``: the folder holds
``supervisord.conf`` and the control socket, and goes away with supervisord.
"""

import os
import shutil
import signal
import sys
import threading
from pathlib import Path

CHUNK = 4096


def main() -> None:
    """Run supervisord until it is told to stop or the pipe ends."""
    from supervisor import supervisord

    folder = Path(sys.argv[1])
    threading.Thread(target=_stop_at_end_of, args=(sys.stdin.fileno(),), daemon=True).start()
    try:
        supervisord.main(["-c", str(folder / "supervisord.conf")])
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _stop_at_end_of(pipe: int) -> None:
    while os.read(pipe, CHUNK):
        pass
    os.kill(os.getpid(), signal.SIGTERM)


if __name__ == "__main__":
    main()
