"""Over-segmentation and the ids of its parts."""

import numpy as np
import pytest

from sceneq_core.mapping.partition import SuperpointParams, VoxelFeatures, partition
from sceneq_core.mapping.superpoints import Superpoints
from sceneq_core.mapping.voxels import Voxels

from support.surfaces import patch, surface

PARAMS = SuperpointParams(refresh_keyframes=1, min_growth=1.0)
NOTHING = np.zeros(0, np.int32)


def sheet(size=8, rgb=(0.5, 0.5, 0.5), normal=(0, 0, 1)):
    grid = np.stack(np.meshgrid(np.arange(size), np.arange(size), indexing="ij"), axis=-1)
    coord = np.concatenate((grid.reshape(-1, 2), np.zeros((size * size, 1))), axis=1)
    count = len(coord)
    return VoxelFeatures(
        coord.astype(np.int32),
        np.tile(np.asarray(normal, np.float64), (count, 1)),
        np.tile(np.asarray(rgb, np.float32), (count, 1)),
    )


def test_one_sheet_in_one_cell_is_one_superpoint():
    assert set(partition(sheet(), PARAMS)) == {0}


def test_colour_cuts():
    features = sheet()
    features.colours[features.coord[:, 0] >= 4] = (0.9, 0.1, 0.1)
    part = partition(features, PARAMS)
    assert len(set(part)) == 2
    assert ((part == part[0]) == (features.coord[:, 0] < 4)).all()


def test_a_fold_cuts():
    features = sheet()
    features.normals_world[features.coord[:, 0] >= 4] = (1, 0, 0)
    part = partition(features, PARAMS)
    assert ((part == part[0]) == (features.coord[:, 0] < 4)).all()


def test_a_small_part_joins_the_more_similar_neighbour():
    features = sheet()
    features.colours[features.coord[:, 0] >= 4] = (0.9, 0.1, 0.1)
    speck = (features.coord[:, 0] == 4) & (features.coord[:, 1] == 3)
    features.colours[speck] = (0.9, 0.3, 0.1)
    part = partition(features, PARAMS)
    assert len(set(part)) == 2
    assert part[speck][0] == part[features.coord[:, 0] == 7][0]


def test_no_part_crosses_a_cell_and_nothing_gives_nothing():
    features = sheet(size=8)
    moved = VoxelFeatures(features.coord - (4, 4, 0), features.normals_world, features.colours)
    order = np.lexsort((moved.coord >> 3).T)
    rows = VoxelFeatures(
        *(column[order] for column in (moved.coord, moved.normals_world, moved.colours))
    )
    assert len(set(partition(rows, PARAMS))) == 4
    empty = VoxelFeatures(
        np.zeros((0, 3), np.int32), np.zeros((0, 3)), np.zeros((0, 3), np.float32)
    )
    assert partition(empty, PARAMS).shape == (0,)


def test_ids_stay_when_the_surface_grows_and_new_surface_gets_new_ids():
    voxels, superpoints = Voxels(0.02), Superpoints(PARAMS)
    touched = voxels.integrate(surface(patch((0.0, 0.1), (0.0, 0.16), 1.0)))
    _, change = superpoints.update(voxels, touched.voxel_id, NOTHING, 0)
    assert change.new_id.tolist() == [0]
    assert change.parent_id.tolist() == [-1]
    more = voxels.integrate(surface(patch((0.0, 0.32), (0.0, 0.16), 1.0)))
    _, change = superpoints.update(voxels, more.voxel_id, NOTHING, 1)
    assert set(superpoints.of(touched.voxel_id)) == {0}
    assert change.new_id.tolist() == [1]
    assert change.gone_id.tolist() == []
    assert superpoints.voxels(np.array([0], np.int32)).tolist() == list(range(40)) + [
        voxel for voxel in range(40, len(voxels)) if superpoints.of(np.array([voxel])) == 0
    ]


def test_a_split_names_its_parent_and_a_vanished_id_is_given_again():
    voxels, superpoints = Voxels(0.02), Superpoints(PARAMS)
    first = voxels.integrate(surface(patch((0.0, 0.16), (0.0, 0.16), 1.0)))
    superpoints.update(voxels, first.voxel_id, NOTHING, 0)
    painted = surface(patch((0.1, 0.16), (0.0, 0.16), 1.0), rgb=(200, 20, 20), weight=50.0)
    touched = voxels.integrate(painted)
    _, change = superpoints.update(voxels, touched.voxel_id, NOTHING, 1)
    assert (change.new_id.tolist(), change.parent_id.tolist()) == ([1], [0])
    voxels.clear(touched.voxel_id)
    _, change = superpoints.update(voxels, NOTHING, touched.voxel_id, 2)
    assert change.gone_id.tolist() == [1]
    assert set(superpoints.of(touched.voxel_id)) == {-1}
    elsewhere = voxels.integrate(surface(patch((0.32, 0.48), (0.0, 0.16), 1.0)))
    _, change = superpoints.update(voxels, elsewhere.voxel_id, NOTHING, 3)
    assert change.new_id.tolist() == [1]


def test_a_settled_cell_waits_for_its_turn():
    voxels, superpoints = Voxels(0.02), Superpoints(SuperpointParams(refresh_keyframes=4))
    sheet_points = surface(patch((0.0, 0.16), (0.0, 0.16), 1.0))
    updated = []
    for keyframe in range(6):
        touched = voxels.integrate(sheet_points)
        updated.append(len(superpoints.update(voxels, touched.voxel_id, NOTHING, keyframe)[0]))
    assert updated == [64, 0, 0, 0, 64, 0]


@pytest.mark.parametrize(
    ("values", "field"),
    [
        ({"max_angle_deg": 0.0}, "max_angle_deg"),
        ({"max_colour": 0.0}, "max_colour"),
        ({"min_voxels": 0}, "min_voxels"),
        ({"refresh_keyframes": 0}, "refresh_keyframes"),
        ({"min_growth": 0.5}, "min_growth"),
    ],
)
def test_a_bad_parameter_is_named(values, field):
    with pytest.raises(ValueError, match=f"^{field}: "):
        SuperpointParams(**values)
