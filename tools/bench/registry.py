"""The benches there are. To add one: a module with its function, and a line here."""

from collections.abc import Callable, Iterator, Mapping
from importlib import import_module

from sceneq_tools.bench.measurement import Measurement, Options

Bench = Callable[[Options], Iterator[Measurement]]

BENCHES: Mapping[str, str] = {
    "codec": "sceneq_tools.bench.codec:codec",
    "bus": "sceneq_tools.bench.bus:bus",
    "render": "sceneq_tools.bench.render:render",
    "stages": "sceneq_tools.bench.stages:stages",
    "stream": "sceneq_tools.bench.stream:stream",
    "laps": "sceneq_tools.bench.laps:laps",
    "query": "sceneq_tools.bench.query:query",
    "scale": "sceneq_tools.bench.scale:scale",
    "link": "sceneq_tools.bench.link:link",
}
ON_REQUEST = frozenset({"link"})
"""Needs root, and minutes: only when it is named."""
NEED_SOURCE = frozenset({"stages", "stream", "laps", "query"})


def load(name: str) -> Bench:
    """Return the bench of that name."""
    module, _, function = BENCHES[name].partition(":")
    bench: Bench = getattr(import_module(module), function)
    return bench
