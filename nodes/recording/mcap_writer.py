"""Writes a recording so that whatever a kill -9 leaves of it can be read."""

import time
from pathlib import Path
from typing import BinaryIO

from mcap.writer import Writer

from sceneq_nodes.recording.forms import Said, store

LIBRARY = "sceneq"
PROFILE = "ros2"
CHUNK_BYTES = 1024 * 1024


class McapWriter:
    """One MCAP file of ROS 2 messages; their types are in it.

    Every ``flush`` ends a chunk and hands it to the kernel: what was flushed outlives the process.
    Index and summary come with ``close``.
    """

    def __init__(self, path: Path) -> None:
        """Begin a file; raise ``ValueError`` when it is there already or cannot be written."""
        try:
            self._file: BinaryIO = path.open("xb")
        except OSError as error:
            raise ValueError(f"{path}: {error.strerror}") from error
        self._writer = Writer(self._file, chunk_size=CHUNK_BYTES)
        self._writer.start(profile=PROFILE, library=LIBRARY)
        self._channels: dict[str, int] = {}
        self._schemas: dict[str, int] = {}
        self._count: dict[str, int] = {}

    def write(self, said: Said) -> None:
        """Add a message; raise ``OSError`` when the disk takes no more."""
        channel = self._channels.get(said.topic)
        if channel is None:
            channel = self._channels[said.topic] = self._open_channel(said)
        number = self._count[said.topic] = self._count.get(said.topic, 0) + 1
        data = bytes(store().serialize_cdr(said.message, said.type_name))
        self._writer.add_message(channel, said.stamp_ns, data, time.time_ns(), number)

    def flush(self) -> None:
        """Make what was written so far outlive this process."""
        self._writer.flush()  # type: ignore[no-untyped-call]

    @property
    def size(self) -> int:
        """Bytes in the file so far."""
        return self._file.tell()

    def close(self) -> None:
        """Write index and summary, and end the file."""
        try:
            self._writer.finish()  # type: ignore[no-untyped-call]
        finally:
            self._file.close()

    def _open_channel(self, said: Said) -> int:
        name = said.type_name
        if name not in self._schemas:
            definition, _ = store().generate_msgdef(name, ros_version=2)
            self._schemas[name] = self._writer.register_schema(name, "ros2msg", definition.encode())
        return self._writer.register_channel(said.topic, "cdr", self._schemas[name])
