"""A scene that is kept new page by page is the scene made at once, whatever the order."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from sceneq_core.encoding.hash import HashEncoder, HashParams
from sceneq_core.mapping.delta import CONFIRMED, REMOVED, TENTATIVE, Instance
from sceneq_core.routing.labels import Labeller, custom
from sceneq_core.routing.revision import Revision
from sceneq_core.routing.scene import PAGE, Scene, SceneSnapshot, ViewRef

UP = np.array([0.0, 0.0, 1.0])
ENCODER = HashEncoder(HashParams())
LABELLER = Labeller(custom(["red cup", "green box", "blue ball"]), ENCODER)
COLOURS = ("red", "green", "blue")
IDS = (1, 2, PAGE - 1, PAGE, 3 * PAGE + 7)
NOBODY = np.zeros(0, np.int32)

ids = st.sampled_from(IDS)
changes = st.lists(
    st.one_of(
        st.tuples(st.just("map"), ids, st.sampled_from([CONFIRMED, TENTATIVE, REMOVED])),
        st.tuples(st.just("views"), ids, st.integers(0, 2)),
        st.tuples(st.just("descriptor"), ids, st.sampled_from(COLOURS)),
        st.tuples(st.just("forget"), ids, st.none()),
        st.tuples(st.just("look"), ids, st.none()),
        st.tuples(st.just("full map"), ids, st.integers(1, 2)),
    ),
    max_size=25,
)


def thing(number: int, state: str = CONFIRMED) -> Instance:
    centre = np.array([number, 0.0, 0.0])
    box = np.stack([centre - 1, centre + 1])
    superpoints = np.array([number], np.int32)
    return Instance(
        number, state, 0, 0, superpoints, 9, centre, box, np.eye(4), np.full(3, 2.0), 0, 1
    )


def views(count: int) -> tuple[ViewRef, ...]:
    return tuple(ViewRef(seq, (0.0, 0.0, 8.0, 8.0)) for seq in range(count))


def tell(scene: Scene, kind: str, number: int, value: object) -> None:
    if kind == "map":
        scene.apply_map(Revision(1, 2), [thing(number, str(value))], UP, full=False)
    elif kind == "views":
        scene.apply_views(1, {number: views(int(str(value)))})
    elif kind == "descriptor":
        scene.apply_descriptors(1, {number: ENCODER.encode_texts([str(value)])[0]}, NOBODY)
    elif kind == "forget":
        scene.apply_descriptors(1, {}, np.array([number], np.int32))
    elif kind == "full map":
        scene.apply_map(Revision(int(str(value)), 1), [thing(number)], UP, full=True)
    else:
        scene.snapshot()


def told(snapshot: SceneSnapshot) -> dict[str, object]:
    return {
        "ids": snapshot.columns.instance_id.tolist(),
        "instances": [(one.instance_id, one.views, one.label) for one in snapshot.instances],
        "waiting": [one.instance_id for one in snapshot.waiting],
        "descriptors": np.asarray(snapshot.descriptors).tolist(),
        "labels": np.asarray(snapshot.label_scores).tolist(),
        "colours": snapshot.columns.colour_scores.tolist(),
        "boxes": snapshot.columns.aabb_world.tolist(),
        "roles": snapshot.columns.role.tolist(),
    }


@settings(max_examples=150, deadline=None)
@given(changes)
def test_looking_in_between_changes_nothing(some: list[tuple[str, int, object]]) -> None:
    looked_at, left_alone = Scene(LABELLER), Scene(LABELLER)
    for kind, number, value in some:
        tell(looked_at, kind, number, value)
        looked_at.snapshot()
        if kind != "look":
            tell(left_alone, kind, number, value)
    assert told(looked_at.snapshot()) == told(left_alone.snapshot())


@settings(max_examples=150, deadline=None)
@given(changes, changes)
def test_a_snapshot_stays_what_it_was(
    before: list[tuple[str, int, object]], after: list[tuple[str, int, object]]
) -> None:
    scene = Scene(LABELLER)
    for change in before:
        tell(scene, *change)
    snapshot = scene.snapshot()
    then = told(snapshot)
    for change in after:
        tell(scene, *change)
        scene.snapshot()
    assert told(snapshot) == then
    found = {number: snapshot.find(number) for number in (*IDS, 5)}
    ids = [one.instance_id for one in snapshot.instances]
    assert ids == sorted(ids)
    assert found == {n: ids.index(n) if n in ids else None for n in (*IDS, 5)}


def test_pages_that_did_not_change_are_shared() -> None:
    scene = Scene(LABELLER)
    scene.apply_map(Revision(1, 1), [thing(number) for number in IDS], UP, full=True)
    scene.apply_views(1, {number: views(1) for number in IDS})
    red = ENCODER.encode_texts(["red"])[0]
    scene.apply_descriptors(1, dict.fromkeys(IDS, red), NOBODY)
    first = scene.snapshot()
    tell(scene, "map", 1, CONFIRMED)
    second = scene.snapshot()
    same = [a is b for a, b in zip(first.instances, second.instances, strict=True)]
    assert same == [False, False, False, True, True]
    rows = zip(first.descriptors, second.descriptors, strict=True)
    assert all(np.shares_memory(a, b) for a, b in rows)
