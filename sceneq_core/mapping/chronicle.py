"""The instances as readers know them, and what they have yet to be told."""

from dataclasses import replace

from sceneq_core.mapping.delta import REMOVED, Event, Instance
from sceneq_core.mapping.lifecycle import Life


class Chronicle:
    """Keeps the instances by id and collects what changes until it is taken.

    Attributes:
        instances: those that are not removed, by id.
        now_ns: the time of what is written.
    """

    def __init__(self) -> None:
        self.instances: dict[int, Instance] = {}
        self.now_ns = 0
        self._news: dict[int, Instance] = {}
        self._events: list[Event] = []

    def take(self) -> tuple[tuple[Instance, ...], tuple[Event, ...]]:
        """Return the instances that changed since the last call, by id, and the events."""
        news = tuple(self._news[instance_id] for instance_id in sorted(self._news))
        events = tuple(self._events)
        self._news, self._events = {}, []
        return news, events

    def write(self, instance: Instance) -> None:
        """Take over how an instance is now."""
        self.instances[instance.instance_id] = self._news[instance.instance_id] = instance

    def enter(self, life: Life, state: str, event: str, looks: Instance | None = None) -> None:
        """Change the state of an instance, which looks as it did or like ``looks``."""
        life.enter(state, self.now_ns)
        changed = replace(
            looks or self.instances[life.instance_id],
            instance_id=life.instance_id,
            state=state,
            parent=life.parent,
            first_seen_ns=life.first_seen_ns,
            state_since_ns=self.now_ns,
            places=life.places,
        )
        self.write(changed)
        self.tell(event, life.instance_id)

    def end(self, instance_id: int, event: str, merged_into: int = 0) -> None:
        """Write that an instance is no more."""
        last = self.instances.pop(instance_id)
        self._news[instance_id] = replace(
            last, state=REMOVED, state_since_ns=self.now_ns, merged_into=merged_into
        )
        self.tell(event, instance_id, merged_into)

    def tell(self, kind: str, instance_id: int, other_id: int = 0) -> None:
        """Add an event."""
        self._events.append(Event(kind, instance_id, other_id, self.now_ns))

    def unsay(self, instance_id: int) -> None:
        """Take back the events of an instance that nobody was told of yet."""
        self._events = [event for event in self._events if event.instance_id != instance_id]
