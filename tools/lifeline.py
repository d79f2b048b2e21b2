"""``supervisord`` on a lifeline: it stops everything when its standard input ends.

The launcher holds the other end of that pipe and nobody else does, so the end comes even when the
launcher is killed with -9. Run as ``python -m sceneq_tools.lifeline -c supervisord.conf``.
"""

import os
import signal
import sys
import threading

CHUNK = 4096


def main() -> None:
    """Run supervisord with the given arguments until it is told to stop or the pipe ends."""
    from supervisor import supervisord

    threading.Thread(target=_stop_at_end_of, args=(sys.stdin.fileno(),), daemon=True).start()
    supervisord.main(sys.argv[1:])


def _stop_at_end_of(pipe: int) -> None:
    while os.read(pipe, CHUNK):
        pass
    os.kill(os.getpid(), signal.SIGTERM)


if __name__ == "__main__":
    main()
