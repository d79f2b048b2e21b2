"""New lines of a log file that somebody else writes and rotates."""

import os
from pathlib import Path
from typing import IO

LAST_BYTES = 8192


class LogTail:
    """Yields whole lines that were added since the last call, across rotation."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._file: IO[bytes] | None = None
        self._rest = b""
        self._open(at_end=True)

    def new_lines(self) -> list[str]:
        """Return the lines written since the last call, without line ends."""
        lines = self._read()
        if self._rotated():
            self._open(at_end=False)
            lines += self._read()
        return lines

    def close(self) -> None:
        """Let the file go."""
        if self._file is not None:
            self._file.close()
            self._file = None

    def _open(self, at_end: bool) -> None:
        self.close()
        self._rest = b""
        if self._path.exists():
            self._file = self._path.open("rb")
            self._file.seek(0, os.SEEK_END if at_end else os.SEEK_SET)

    def _read(self) -> list[str]:
        if self._file is None:
            return []
        *lines, self._rest = (self._rest + self._file.read()).split(b"\n")
        return [line.decode("utf-8", "replace") for line in lines]

    def _rotated(self) -> bool:
        if not self._path.exists():
            return False
        if self._file is None:
            return True
        ours, now = os.fstat(self._file.fileno()), self._path.stat()
        return (ours.st_dev, ours.st_ino) != (now.st_dev, now.st_ino)


def last_line(path: Path) -> str:
    """Return the last line with text in a log file, '' when there is none."""
    try:
        with path.open("rb") as file:
            file.seek(max(0, path.stat().st_size - LAST_BYTES))
            lines = [line.strip() for line in file.read().splitlines()]
    except OSError:
        return ""
    return next((line.decode("utf-8", "replace") for line in reversed(lines) if line), "")
