"""Which keyframes are kept out of the map, and which are let in after all."""

from copy import copy
from dataclasses import replace

import numpy as np
import pytest

from sceneq_core.mapping.correction import Correction
from sceneq_core.mapping.digest import map_digest
from sceneq_core.mapping.mapper import Mapper
from sceneq_core.mapping.quarantine import Quarantine, QuarantineParams
from sceneq_core.mapping.replica import MapReplica
from sceneq_core.visits import seq_in_scene

from support.room import THINGS, Room
from support.surfaces import SMALL, room_frames

VIEWS = room_frames(12)


def spoiled(view, **images):
    frame, labels = view
    changed = {name: change(copy(getattr(frame, name))) for name, change in images.items()}
    return replace(frame, **changed), labels


def with_pose(view, change):
    return spoiled(view, T_world_camera=change)


def shifted(metres):
    def change(pose):
        pose[:3, 3] += metres
        return pose

    return change


def turned(degrees):
    angle = np.radians(degrees)
    about_z = np.array(
        [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
    )

    def change(pose):
        pose[:3, :3] = about_z @ pose[:3, :3]
        return pose

    return change


def set_to(value, *where):
    def change(image):
        image[where] = value
        return image

    return change


DEFAULT = QuarantineParams()


def fed(views, params=DEFAULT):
    """Return the frames let in, as seqs in order, and the reason by seq."""
    quarantine, inside, reasons = Quarantine(params), [], {}
    for frame, labels in views:
        admission = quarantine.admit(frame, labels)
        inside += [f.seq for f, _ in admission.keyframes]
        if admission.reason:
            reasons[frame.seq] = admission.reason
    return inside, reasons


def test_two_robots_are_not_one_that_leaps_to_and_fro():
    """Taken for one camera, going from one room to the other and back would be jumps."""
    ends = [(view, with_pose(view, shifted(10.0))) for view in VIEWS[:5]]
    as_one = [
        (replace(frame, seq=n, stamp_ns=n * 50_000_000), labels)
        for n, (frame, labels) in enumerate(view for pair in ends for view in pair)
    ]
    as_two = [
        (replace(frame, seq=seq_in_scene(n % 2, n)), labels)
        for n, (frame, labels) in enumerate(as_one)
    ]
    assert fed(as_one)[1]
    inside, reasons = fed(as_two)
    assert (len(inside), reasons) == (len(as_two), {})


def test_a_steady_camera_passes():
    inside, reasons = fed(VIEWS)
    assert inside == list(range(12))
    assert reasons == {}


HALF = slice(60, None)
FAULTS = {
    "depth not finite": lambda v: spoiled(v, depth_m=set_to(np.nan, 3, 4)),
    "hardly any depth": lambda v: spoiled(v, depth_m=set_to(0, slice(None), slice(1, None))),
    "colour black": lambda v: spoiled(v, rgb=set_to(0, HALF)),
    "depth cut off": lambda v: spoiled(v, depth_m=set_to(0, HALF)),
    "pose not rigid": lambda v: with_pose(v, lambda pose: pose * 1.2),
    "pose jumped": lambda v: with_pose(v, shifted((0, 0, 50.0))),
    "map contradicted": lambda v: with_pose(v, turned(40)),
}


@pytest.mark.parametrize("kind", FAULTS)
def test_a_bad_keyframe_is_kept_out_and_the_next_ones_pass(kind):
    inside, reasons = fed([*VIEWS[:5], FAULTS[kind](VIEWS[5]), *VIEWS[6:]])
    assert inside == [0, 1, 2, 3, 4, 6, 7, 8, 9, 10, 11]
    assert list(reasons) == [5]
    assert reasons[5].startswith(kind)


def test_a_black_half_of_the_other_side_counts_as_well():
    left = spoiled(VIEWS[5], rgb=set_to(0, slice(None), slice(0, 80)))
    assert fed([*VIEWS[:5], left])[1][5] == "colour black: 50% of the image"


def test_ragged_holes_are_no_cut():
    holes = VIEWS[5][0].depth_m.copy()
    for row in range(60):
        holes[60 + row, row : 160 - row // 2] = 0
    assert fed([*VIEWS[:5], spoiled(VIEWS[5], depth_m=lambda _: holes)])[1] == {}


def test_a_sensor_that_measures_only_half_is_believed_in_the_end():
    views = [*VIEWS[:4], *[FAULTS["depth cut off"](view) for view in VIEWS[4:]]]
    assert fed(views)[0] == [0, 1, 2, 3, *range(6, 12)]


def test_a_camera_carried_to_an_unknown_place_loses_no_keyframe():
    elsewhere = [with_pose(view, shifted((40.0, 0, 0))) for view in VIEWS[6:]]
    inside, reasons = fed([*VIEWS[:6], *elsewhere])
    assert inside == list(range(12))
    assert reasons == {6: "pose jumped: 40.2 m and 5 degrees in 0.1 s"}


def changed_views(seconds=0.3):
    """Return later views of the room without its table and what stood on it."""
    room = Room(things=tuple(t for t in THINGS if t.name not in ("table", "red ball", "blue box")))
    start_ns = VIEWS[-1][0].stamp_ns
    return [
        (replace(f, seq=12 + i, stamp_ns=start_ns + round((i + 1) * seconds * 1e9)), labels)
        for i, (f, labels) in enumerate(reversed(room_frames(12, room)))
    ]


def test_a_changed_scene_is_believed_when_views_agree_for_long_enough():
    inside, reasons = fed([*VIEWS, *changed_views()])
    assert inside == list(range(24))
    assert reasons[12].startswith("map contradicted: ")
    assert list(reasons) == [12, 13]


def test_at_another_rate_the_same_time_passes():
    assert list(fed([*VIEWS, *changed_views(seconds=0.1)])[1]) == [12, 13, 14, 15, 16]


def test_a_lost_pose_is_refused_until_it_was_claimed_as_often_as_the_rest():
    lost = [with_pose(view, shifted((0, -0.6, 0.6))) for view in changed_views()]
    quarantine, reasons = Quarantine(QuarantineParams()), []
    for frame, labels in [*VIEWS, *lost]:
        reasons.append(quarantine.admit(frame, labels).reason)
    assert all(reasons[12:23])
    assert reasons[14].startswith("pose lost: for 3 keyframes, map contradicted: ")
    assert reasons[23] == ""


def test_what_is_held_is_bounded():
    params = QuarantineParams(max_held=2, confirm_views=4)
    inside, _ = fed([*VIEWS, *changed_views()], params)
    assert inside == [*range(12), *range(14, 24)]


def test_switched_off_it_lets_all_pass():
    views = [*VIEWS[:3], FAULTS["pose jumped"](VIEWS[3])]
    assert fed(views, QuarantineParams(enabled=False))[0] == [0, 1, 2, 3]


def test_a_change_is_held_back_once():
    reasons = fed([*VIEWS, *changed_views(), *later(changed_views(), 12)])[1]
    assert list(reasons) == [12, 13]


def later(views, frames):
    return [
        (replace(f, seq=f.seq + frames, stamp_ns=f.stamp_ns + frames * 300_000_000), labels)
        for f, labels in views
    ]


def test_views_move_along_when_poses_are_corrected():
    moved = [with_pose(view, shifted((2.0, 0, 0))) for view in VIEWS]
    quarantine = Quarantine(QuarantineParams())
    for frame, labels in VIEWS[:6]:
        quarantine.admit(frame, labels)
    poses = np.stack([frame.T_world_camera for frame, _ in moved[:6]])
    quarantine.correct(Correction(np.arange(6), poses))
    assert [quarantine.admit(*view).reason for view in moved[6:]] == [""] * 6


def test_the_delta_says_why_and_the_map_stays():
    mapper = Mapper(SMALL)
    for view in VIEWS[:4]:
        mapper.integrate(*view)
    delta = mapper.integrate(*FAULTS["map contradicted"](VIEWS[4]))
    assert delta.quarantined.startswith("map contradicted: ")
    assert (delta.frame_seq, delta.stamp_ns) == (4, VIEWS[4][0].stamp_ns)
    assert len(delta.voxel_id) == len(delta.instances) == 0
    assert mapper.integrate(*VIEWS[5]).quarantined == ""


def test_what_is_held_back_moves_along_too():
    quarantine = Quarantine(QuarantineParams())
    for frame, labels in [*VIEWS[:6], with_pose(VIEWS[6], shifted((40.0, 0, 0)))]:
        quarantine.admit(frame, labels)
    poses = np.stack([frame.T_world_camera for frame, _ in VIEWS[:7]])
    quarantine.correct(Correction(np.arange(7), poses))
    admission = quarantine.admit(*VIEWS[7])
    assert [frame.seq for frame, _ in admission.keyframes] == [6, 7]
    held, _ = admission.keyframes[0]
    assert np.array_equal(held.T_world_camera, VIEWS[6][0].T_world_camera)


def digest_of(deltas):
    replica = MapReplica()
    for delta in deltas:
        replica.apply(delta)
    points, _, instance_id = replica.cloud()
    return map_digest(np.floor(points / replica.voxel_size_m).astype(np.int32), points, instance_id)


def test_what_is_let_in_later_makes_the_same_map():
    elsewhere = [with_pose(view, shifted((40.0, 0, 0))) for view in VIEWS[4:7]]
    off = replace(SMALL, quarantine=QuarantineParams(enabled=False))
    deltas, plain = (
        [mapper.integrate(*view) for view in [*VIEWS[:4], *elsewhere]]
        for mapper in (Mapper(SMALL), Mapper(off))
    )
    assert [bool(d.quarantined) for d in deltas] == [False] * 4 + [True, False, False]
    assert digest_of(deltas) == digest_of(plain)
    told = [sorted({i.instance_id for d in run for i in d.instances}) for run in (deltas, plain)]
    assert told[0] == told[1]


def test_a_quick_turn_is_let_in_when_a_slower_view_confirms_it():
    views = [VIEWS[0], spoiled(VIEWS[7], stamp_ns=lambda _: 100_000_000)]
    slow = spoiled(VIEWS[8], stamp_ns=lambda _: 3_000_000_000)
    inside, reasons = fed([*views, slow], QuarantineParams(min_cover_jump=0.9))
    assert inside == [0, 7, 8]
    assert list(reasons) == [7]


@pytest.mark.parametrize(
    ("field", "value"),
    [("min_agreement", 1.0), ("max_speed_m_s", 0.0), ("confirm_views", 1), ("confirm_s", -1.0)],
)
def test_parameters_out_of_their_limits_are_refused(field, value):
    with pytest.raises(ValueError, match=f"^{field}: "):
        QuarantineParams(**{field: value})
