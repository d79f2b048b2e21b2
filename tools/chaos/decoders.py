"""Every decoder of the program."""

from collections.abc import Iterator
from pathlib import Path

from sceneq_tools.chaos.decoder import Decoder
from sceneq_tools.chaos.file_decoders import file_decoders
from sceneq_tools.chaos.node_decoders import node_decoders
from sceneq_tools.chaos.question_decoders import question_decoders
from sceneq_tools.chaos.store_decoders import store_decoders
from sceneq_tools.chaos.wire_decoders import message_decoders, other_decoders


def decoders(folder: Path) -> Iterator[Decoder]:
    """Yield them all; files are written to ``folder``."""
    yield from message_decoders()
    yield from other_decoders()
    yield from question_decoders()
    yield from file_decoders(folder)
    yield from store_decoders(folder)
    yield from node_decoders()
