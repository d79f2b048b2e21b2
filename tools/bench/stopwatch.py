"""Times functions of the running program from outside, so that none of them carries a clock."""

import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import wraps
from importlib import import_module
from typing import Any


class Stopwatch:
    """How long each call took: ``taken_ms[stage]``, in the order of the calls.

    ``after`` is told the stage after each of its calls, with the watch stopped.
    """

    def __init__(
        self,
        after: Callable[[str], None] | None = None,
        clock: Callable[[], float] = time.perf_counter,
    ) -> None:
        self._after = after
        self._clock = clock
        self.taken_ms: dict[str, list[float]] = {}

    @contextmanager
    def watching(self, stages: Mapping[str, str]) -> Iterator[None]:
        """Time ``stage -> "module:function"`` or ``"module:Class.method"`` within the block.

        What one watched function calls of another counts for both.

        Raises:
            AttributeError, ImportError: there is no such function.
        """
        restore = [self._watch(stage, target) for stage, target in stages.items()]
        try:
            yield
        finally:
            for undo in restore:
                undo()

    def _watch(self, stage: str, target: str) -> Callable[[], None]:
        module, _, path = target.partition(":")
        *parents, name = path.split(".")
        owner: Any = import_module(module)
        for parent in parents:
            owner = getattr(owner, parent)
        plain = getattr(owner, name)
        setattr(owner, name, self._timed(stage, plain))
        return lambda: setattr(owner, name, plain)

    def _timed(self, stage: str, plain: Callable[..., Any]) -> Callable[..., Any]:
        taken_ms = self.taken_ms.setdefault(stage, [])

        @wraps(plain)
        def timed(*args: Any, **kwargs: Any) -> Any:
            start_s = self._clock()
            try:
                return plain(*args, **kwargs)
            finally:
                taken_ms.append(1000 * (self._clock() - start_s))
                if self._after is not None:
                    self._after(stage)

        return timed
