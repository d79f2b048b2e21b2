"""A reader that misses, repeats or reorders deltas ends with the writer's state."""

from dataclasses import dataclass, field, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sceneq_nodes._bus import QueryError, Reply, Request
from sceneq_nodes._follow import QUIET_S, RETRY_S, Follower, Pull
from sceneq_schemas.codec import encode
from sceneq_schemas.map import MapDelta, MapDeltas
from sceneq_schemas.topics import (
    MAP_DELTA,
    MAP_JOURNAL,
    MAP_SNAPSHOT,
    VIEW_DELTA,
    VIEW_SNAPSHOT,
)
from sceneq_schemas.view import ViewDelta, ViewSet

from support.fake_bus import FakeBus
from support.messages import EXAMPLES

EXAMPLE = next(message for message in EXAMPLES if isinstance(message, MapDelta))


@dataclass
class Writer:
    """Publishes one new view set per delta and answers the snapshot."""

    epoch: int = 1
    deltas: list[ViewDelta] = field(default_factory=list)

    def write(self) -> ViewDelta:
        seq = len(self.deltas) + 1
        self.deltas.append(self.message(seq, (ViewSet(seq, ()),), full=False))
        return self.deltas[-1]

    def snapshot(self) -> ViewDelta:
        every = tuple(s for delta in self.deltas for s in delta.view_sets)
        return self.message(len(self.deltas), every, full=True)

    def message(self, seq: int, view_sets: tuple[ViewSet, ...], full: bool) -> ViewDelta:
        return ViewDelta(
            epoch=self.epoch,
            seq=seq,
            full=full,
            frame_seq=seq,
            stamp_ns=seq,
            map_epoch=1,
            map_seq=1,
            view_sets=view_sets,
        )

    def reply(self, _request: object) -> Reply:
        return Reply(encode(self.snapshot()), VIEW_SNAPSHOT.encoding)


class Reader:
    """The state as a node would keep it: the ids of all view sets applied, in order."""

    def __init__(self, bus: FakeBus) -> None:
        self.now = 0.0
        self.ids: list[int] = []
        self.follower = Follower(
            bus, VIEW_DELTA, VIEW_SNAPSHOT, self.apply, clock=lambda: self.now, scene="room"
        )
        self.follower.open()

    def apply(self, delta: ViewDelta) -> None:
        new = [view_set.instance_id for view_set in delta.view_sets]
        self.ids = new if delta.full else self.ids + new

    def wait(self) -> None:
        self.now += RETRY_S
        self.follower.tick()


@pytest.fixture
def bus() -> FakeBus:
    return FakeBus()


def test_follows_from_the_first_delta_without_a_snapshot(bus: FakeBus) -> None:
    writer, reader = Writer(), Reader(bus)
    for _ in range(3):
        reader.follower.offer(writer.write())
    assert reader.ids == [1, 2, 3]
    assert reader.follower.synced
    assert (reader.follower.epoch, reader.follower.seq) == (1, 3)
    assert bus.subscriptions == {"sceneq/view/room/delta/v1": 64}


def test_late_reader_starts_from_the_snapshot(bus: FakeBus) -> None:
    writer = Writer()
    for _ in range(4):
        writer.write()
    bus.answer(VIEW_SNAPSHOT, writer.reply)
    reader = Reader(bus)
    assert reader.ids == [1, 2, 3, 4]
    reader.follower.offer(writer.write())
    assert reader.ids == [1, 2, 3, 4, 5]
    assert reader.follower.resyncs == 0


def test_gap_is_healed_by_the_snapshot(bus: FakeBus) -> None:
    writer, reader = Writer(), Reader(bus)
    bus.answer(VIEW_SNAPSHOT, writer.reply)
    reader.wait()
    reader.follower.offer(writer.write())
    writer.write()
    reader.now += RETRY_S
    reader.follower.offer(writer.write())
    assert reader.ids == [1, 2, 3]
    assert reader.follower.resyncs == 1
    assert bus.counters["view_delta_resyncs"] == 1


def test_deltas_wait_while_nobody_answers_the_snapshot(bus: FakeBus) -> None:
    writer, reader = Writer(), Reader(bus)
    reader.follower.offer(writer.write())
    writer.write()
    for _ in range(3):
        reader.follower.offer(writer.write())
    assert reader.ids == [1]
    assert not reader.follower.synced
    old = replace(writer.snapshot(), seq=2, view_sets=(ViewSet(1, ()), ViewSet(2, ())))
    bus.answer(VIEW_SNAPSHOT, lambda _: Reply(encode(old), VIEW_SNAPSHOT.encoding))
    reader.wait()
    assert reader.ids == [1, 2, 3, 4, 5]
    assert reader.follower.synced


def test_snapshot_that_is_still_too_old_is_asked_for_again(bus: FakeBus) -> None:
    writer, reader = Writer(), Reader(bus)
    reader.follower.offer(writer.write())
    stale = writer.snapshot()
    bus.answer(VIEW_SNAPSHOT, lambda _: Reply(encode(stale), VIEW_SNAPSHOT.encoding))
    writer.write()
    reader.now += RETRY_S
    reader.follower.offer(writer.write())
    assert not reader.follower.synced
    bus.answer(VIEW_SNAPSHOT, writer.reply)
    reader.wait()
    assert reader.ids == [1, 2, 3]
    assert reader.follower.synced


def test_duplicates_and_late_arrivals_are_ignored(bus: FakeBus) -> None:
    writer, reader = Writer(), Reader(bus)
    first, second = writer.write(), writer.write()
    for delta in (first, second, first, second):
        reader.follower.offer(delta)
    assert reader.ids == [1, 2]
    assert reader.follower.resyncs == 0


def test_writer_restart_replaces_the_state(bus: FakeBus) -> None:
    old, reader = Writer(epoch=1), Reader(bus)
    for _ in range(3):
        reader.follower.offer(old.write())
    new = Writer(epoch=2)
    reader.follower.offer(new.write())
    assert reader.ids == [1]
    assert reader.follower.epoch == 2
    assert reader.follower.resyncs == 1


def test_restart_whose_first_delta_was_lost_needs_the_snapshot(bus: FakeBus) -> None:
    old, new, reader = Writer(epoch=1), Writer(epoch=2), Reader(bus)
    for _ in range(3):
        reader.follower.offer(old.write())
    new.write()
    bus.answer(VIEW_SNAPSHOT, new.reply)
    reader.now += RETRY_S
    reader.follower.offer(new.write())
    assert reader.ids == [1, 2]
    assert (reader.follower.epoch, reader.follower.seq) == (2, 2)


def test_full_delta_needs_no_predecessor(bus: FakeBus) -> None:
    writer, reader = Writer(), Reader(bus)
    for _ in range(5):
        writer.write()
    reader.follower.offer(writer.snapshot())
    assert reader.ids == [1, 2, 3, 4, 5]
    assert reader.follower.synced


def test_asking_is_rate_limited(bus: FakeBus) -> None:
    writer, reader = Writer(), Reader(bus)
    writer.write()
    for _ in range(20):
        reader.follower.offer(writer.write())
        reader.follower.tick()
    assert len(bus.asked) == 1
    reader.wait()
    assert len(bus.asked) == 2


@pytest.mark.parametrize("payload", [b"", b"\xc1", encode(ViewSet(1, ()))])
def test_bad_snapshot_is_counted_and_asked_for_again(bus: FakeBus, payload: bytes) -> None:
    bus.answer(VIEW_SNAPSHOT, lambda _: Reply(payload, VIEW_SNAPSHOT.encoding))
    reader = Reader(bus)
    assert bus.counters["view_snapshot_failed"] == 1
    writer = Writer()
    writer.write()
    bus.answer(VIEW_SNAPSHOT, writer.reply)
    reader.wait()
    assert reader.ids == [1]


def test_refused_snapshot_is_counted(bus: FakeBus) -> None:
    def refuse(_request: object) -> Reply:
        raise QueryError("busy", "32 queries wait", retry_ms=100)

    bus.answer(VIEW_SNAPSHOT, refuse)
    reader = Reader(bus)
    assert bus.counters["view_snapshot_failed"] == 1
    assert not reader.follower.synced


@settings(max_examples=100, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), answering=st.floats(0.2, 1.0))
def test_any_loss_reorder_or_restart_ends_in_the_writers_state(seed: int, answering: float) -> None:
    rng = np.random.default_rng(seed)
    bus = FakeBus()
    writer, reader = Writer(), Reader(bus)
    bus.answer(VIEW_SNAPSHOT, lambda r: writer.reply(r) if rng.random() < answering else None)
    line: list[ViewDelta] = []
    for _ in range(40):
        if rng.random() < 0.05 and writer.deltas:
            writer = Writer(epoch=writer.epoch + 1)
            line.clear()
        delta = writer.write()
        line += [delta] * int(rng.integers(0, 3))
        rng.shuffle(line)  # type: ignore[arg-type]
        for _ in range(int(rng.integers(0, len(line) + 1))):
            reader.now += 0.2
            reader.follower.offer(line.pop())
    bus.answer(VIEW_SNAPSHOT, writer.reply)
    reader.now += RETRY_S
    reader.follower.offer(writer.write())
    assert reader.ids == [view_set.instance_id for view_set in writer.snapshot().view_sets]
    assert reader.follower.synced


class Journal:
    """A writer that still knows its deltas beyond ``first``."""

    def __init__(self, bus: FakeBus, writer: Writer, first: int) -> None:
        self.writer, self.first = writer, first
        self.asked: list[dict[str, str]] = []
        bus.answer(MAP_JOURNAL, self.reply)

    def reply(self, request: Request) -> Reply | None:
        self.asked.append(dict(request.parameters))
        after = int(request.parameters["after"])
        if after < self.first:
            return None
        maps = tuple(
            replace(EXAMPLE, epoch=one.epoch, seq=one.seq) for one in self.writer.deltas[after:]
        )
        seq = len(self.writer.deltas)
        return Reply(encode(MapDeltas(self.writer.epoch, seq, maps)), MAP_JOURNAL.encoding)


class MapReader:
    """Keeps the numbers of the deltas applied."""

    def __init__(
        self, bus: FakeBus, have: tuple[int, int] | None = None, pull: Pull | None = None
    ) -> None:
        self.now = 0.0
        self.seqs: list[int] = []
        self.follower = Follower(
            *(bus, MAP_DELTA, MAP_SNAPSHOT, lambda delta: self.seqs.append(delta.seq)),
            clock=lambda: self.now,
            journal_topic=MAP_JOURNAL,
            pull=pull,
            have=have,
            scene="room",
        )
        self.follower.open()


def test_a_gap_is_healed_delta_by_delta_where_the_writer_knows_them(bus: FakeBus) -> None:
    writer = Writer()
    for _ in range(5):
        writer.write()
    journal = Journal(bus, writer, first=2)
    reader = MapReader(bus, have=(writer.epoch, 3))
    assert reader.seqs == [4, 5]
    assert (reader.follower.epoch, reader.follower.seq) == (writer.epoch, 5)
    assert reader.follower.synced
    where = {"epoch": str(writer.epoch), "after": "3", "merged": "1", "page": "0"}
    assert journal.asked == [where]


def test_who_begins_follows_from_the_very_beginning(bus: FakeBus) -> None:
    writer = Writer()
    for _ in range(3):
        writer.write()
    Journal(bus, writer, first=0)
    reader = MapReader(bus, have=(0, 0))
    assert reader.seqs == [1, 2, 3]
    assert reader.follower.epoch == writer.epoch


def test_what_the_writer_forgot_is_healed_by_the_whole(bus: FakeBus) -> None:
    writer = Writer()
    for _ in range(5):
        writer.write()
    Journal(bus, writer, first=4)
    whole = replace(EXAMPLE, epoch=writer.epoch, seq=5, full=True)
    bus.answer(MAP_SNAPSHOT, lambda request: Reply(encode(whole), MAP_SNAPSHOT.encoding))
    reader = MapReader(bus, have=(writer.epoch, 1))
    assert reader.seqs == [5]
    assert reader.follower.synced


def test_a_last_delta_that_was_lost_is_found_when_nothing_follows(bus: FakeBus) -> None:
    writer = Writer()
    writer.write()
    Journal(bus, writer, first=0)
    reader = MapReader(bus, have=(writer.epoch, 0))
    writer.write()
    reader.now += QUIET_S - 0.1
    reader.follower.tick()
    assert reader.seqs == [1]
    reader.now += 0.1
    reader.follower.tick()
    assert reader.seqs == [1, 2]
    assert reader.follower.resyncs == 0


def test_over_a_thin_link_changes_are_asked_for_now_and_then(bus: FakeBus) -> None:
    writer = Writer()
    writer.write()
    journal = Journal(bus, writer, first=0)
    reader = MapReader(bus, have=(0, 0), pull=Pull(every_s=5.0, mbit_s=1000.0))
    assert bus.subscriptions == {}
    for _ in range(3):
        writer.write()
        reader.now += 2.0
        reader.follower.tick()
    assert reader.seqs == [1, 2, 3, 4]
    assert [one["after"] for one in journal.asked] == ["0", "1"]


def test_a_thin_link_that_is_cut_is_told(bus: FakeBus) -> None:
    writer = Writer()
    writer.write()
    Journal(bus, writer, first=0)
    reader = MapReader(bus, have=(0, 0), pull=Pull(every_s=5.0, mbit_s=1000.0))
    assert reader.follower.synced
    bus.answer(MAP_JOURNAL, lambda _: None)
    reader.now += 5.0
    reader.follower.tick()
    assert not reader.follower.synced
