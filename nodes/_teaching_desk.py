"""The queryables of names: give one, take one back, list them all.

A request that changes something must name its key exactly: a wildcard changes nothing.
"""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from sceneq_core.routing.scene import SceneSnapshot
from sceneq_core.teaching.pointing import at_point, in_box, keyframes
from sceneq_core.teaching.taught import Spot, Taught
from sceneq_nodes._answer_json import Json
from sceneq_nodes._ask import read_ask, reply
from sceneq_nodes._bus import QueryError, Reply, Request
from sceneq_nodes._look import no_such
from sceneq_nodes._name_keeper import NameKeeper
from sceneq_nodes._names_json import name_json
from sceneq_nodes._space import Space
from sceneq_nodes._teach_request import ForgetRequest, TeachRequest, read_forget, read_teach

SHOWN_KEYFRAMES = 10


class TeachingDesk:
    """Answers ``set``, ``forget`` and ``names``; ``space`` is the one that answers come from."""

    def __init__(self, scene: str, keeper: NameKeeper, space: Callable[[], Space]) -> None:
        self._scene = scene
        self._keeper = keeper
        self._space = space

    def set(self, request: Request) -> Reply | None:
        """Give a name to an instance."""
        if request.wildcard:
            return None
        wish = read_teach(request)
        with self._keeper.lock, _written():
            space = self._space()
            pointed_at = self._pick(wish, space.look.snapshot)
            new = self._taught(wish, pointed_at[0], space)
            replaced = () if new in self._keeper.taught else self._keeper.teach(new)
            space.rename()
            body = {
                "status": "taught",
                **self._json(new),
                "replaced": [self._json(old) for old in replaced],
                "pointed_at": pointed_at if wish.view is not None else [],
            }
        return reply({**body, **self._kept()}, "taught", wish.fmt)

    def forget(self, request: Request) -> Reply | None:
        """Take names back."""
        if request.wildcard:
            return None
        wish = read_forget(request)
        with self._keeper.lock, _written():
            names = self._meant(wish)
            told = [self._json(one) for one in names]
            self._keeper.forget(names)
            self._space().rename()
        return reply({"status": "forgotten", "names": told, **self._kept()}, "forgotten", wish.fmt)

    def names(self, request: Request) -> Reply | None:
        """List what was taught, who inherits it, and which names have lost their instance."""
        ask = read_ask(request)
        if request.wildcard and ask.text:
            return None
        with self._keeper.lock:
            names = [self._json(one) for one in self._keeper.taught]
        return reply({"scene": self._scene, "names": names, **self._kept()}, "names", ask.fmt)

    def _pick(self, wish: TeachRequest, snapshot: SceneSnapshot) -> list[int]:
        """Return the ids that a request may mean, best first; one at least."""
        if wish.instance_id is not None:
            return [wish.instance_id]
        assert wish.view is not None
        if wish.point is not None:
            found = at_point(snapshot, wish.view, *wish.point)
        else:
            assert wish.box is not None
            found = in_box(snapshot, wish.view, wish.box)
        if not found:
            last = keyframes(snapshot)[-SHOWN_KEYFRAMES:]
            where = f"no instance has a view there in keyframe {wish.view}"
            raise QueryError("not_found", where, f"the last keyframes with views: {last}")
        return found

    def _taught(self, wish: TeachRequest, instance_id: int, space: Space) -> Taught:
        """Return the new name, or the very same one if it was taught before."""
        snapshot = space.look.snapshot
        row, looks = snapshot.find(instance_id), space.album.looks_of(instance_id)
        if row is None or looks is None:
            if any(one.instance_id == instance_id for one in snapshot.waiting):
                what = f"instance {instance_id} was not seen well enough yet"
                raise QueryError("not_ready", what, "try again in a moment", retry_ms=1000)
            raise no_such(instance_id, self._scene)
        for one in self._keeper.names_of(instance_id):
            if (one.name, one.kind, one.by) == (wish.name, wish.kind, wish.by):
                return one
        spot = Spot.of(snapshot.instances[row].geometry, snapshot.revision.epoch)
        number = self._keeper.next_number
        return Taught(number, wish.name, wish.kind, wish.by, time.time_ns(), spot, looks)

    def _meant(self, wish: ForgetRequest) -> tuple[Taught, ...]:
        names = self._keeper.find(wish.name) if wish.name else self._keeper.taught
        if wish.instance_id is not None:
            own = self._keeper.names_of(wish.instance_id)
            names = tuple(one for one in names if one in own)
        if not names:
            what = repr(wish.name) if wish.name else f"of instance {wish.instance_id}"
            hint = f"list them: sceneq/query/{self._scene}/names"
            raise QueryError("not_found", f"there is no such name: {what}", hint)
        return names

    def _json(self, one: Taught) -> Json:
        return name_json(one, self._keeper, self._space().look.snapshot)

    def _kept(self) -> Json:
        """Whether names outlive the process, and what is wrong with their file if anything is."""
        problem = {"problem": self._keeper.problem} if self._keeper.problem else {}
        return {"kept": self._keeper.keeps, **problem}


@contextmanager
def _written() -> Iterator[None]:
    """Turn what a full book or a full disk says into the answer; nothing has changed then."""
    try:
        yield
    except ValueError as error:
        raise QueryError("too_many", str(error), "forget some first") from error
    except OSError as error:
        what = f"the name cannot be written: {error.strerror or error}"
        raise QueryError("not_kept", what, "make room on the disk of the routing node") from error
