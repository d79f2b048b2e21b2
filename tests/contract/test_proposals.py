"""What every source of external proposals promises, and the files that the file source reads."""

import re
from pathlib import Path

import numpy as np
import pytest

from sceneq_core.mapping.proposals import Proposals
from sceneq_nodes._backends import build, kinds
from sceneq_nodes._params import ParamError

POINTS = np.array([[0, 0, 1], [0.1, 0, 1], [0.2, 0, 1], [0.3, 0, 1]], np.float32)
SPECS = {"none": lambda folder: {}, "file": lambda folder: {"path": str(npz(folder))}}


def npz(folder: Path, **fields: object) -> Path:
    path = folder / "proposals.npz"
    given = {"points_world": POINTS, "mask_id": [0, 0, 1], "point_id": [0, 1, 3]} | fields
    np.savez(path, **{name: value for name, value in given.items() if value is not None})
    return path


def loaded(path: Path, **params: str) -> Proposals:
    return build("proposals", {"kind": "file", "path": str(path), **params}).load()


def test_every_kind_of_ours_is_tried() -> None:
    assert set(SPECS) <= set(kinds("proposals"))


@pytest.mark.parametrize("kind", SPECS)
def test_what_is_loaded_is_proposals_or_none_and_the_same_twice(kind: str, tmp_path: Path) -> None:
    source = build("proposals", {"kind": kind, **SPECS[kind](tmp_path)})
    first, again = source.load(), source.load()
    if first is None:
        assert again is None
        return
    assert isinstance(first, Proposals)
    assert np.array_equal(first.of_points(), again.of_points())


def test_pairs_may_overlap_and_scores_decide(tmp_path: Path) -> None:
    path = npz(
        tmp_path,
        mask_id=[0, 0, 1, 1],
        point_id=[0, 1, 1, 2],
        score=[0.3, 0.8],
        label=np.array(["chair", "door"]),
    )
    proposals = loaded(path)
    assert proposals.of_points().tolist() == [0, 1, 1, -1]
    assert proposals.label == ("chair", "door")


def test_an_instance_number_per_point_is_enough(tmp_path: Path) -> None:
    path = npz(tmp_path, mask_id=None, point_id=None, instance=[7, 0, 3, 7])
    assert loaded(path).of_points().tolist() == [1, -1, 0, 1]


@pytest.mark.parametrize(
    ("fields", "says"),
    [
        ({"points_world": None}, "points_world: missing, there are mask_id, point_id"),
        ({"points_world": POINTS.astype(int)}, "points_world: cannot be int64"),
        ({"mask_id": [0.5, 1.5, 0.0]}, "mask_id: cannot be float64"),
        ({"point_id": [0, 1, 9]}, "point_id: expected 0 to 3, got 0 to 9"),
        ({"instance": [1, 2]}, "instance: expected (4,), got (2,)"),
    ],
)
def test_a_wrong_field_is_named_with_the_file(
    fields: dict[str, object], says: str, tmp_path: Path
) -> None:
    path = npz(tmp_path, **fields)
    with pytest.raises(ValueError, match=re.escape(f"{path}: {says}")):
        loaded(path)


def test_a_file_that_is_no_npz_is_named(tmp_path: Path) -> None:
    path = tmp_path / "x.npz"
    path.write_bytes(b"PK\x03\x04 no zip")
    with pytest.raises(ValueError, match=re.escape(str(path))):
        loaded(path)


def scannet(folder: Path, masks: list[str]) -> tuple[Path, Path]:
    """Write a cloud and predictions over its vertices."""
    cloud, listed = folder / "cloud.ply", folder / "scene.txt"
    rows = "\n".join(" ".join(map(str, row)) for row in POINTS.tolist())
    header = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
    cloud.write_text(f"{header}property float z\nend_header\n{rows}\n")
    for i, mask in enumerate(masks):
        (folder / f"mask_{i}.txt").write_text(mask)
    lines = [f"mask_{i}.txt {5 + i} 0.{9 - i}" for i in range(len(masks))]
    listed.write_text("\n".join(lines))
    return listed, cloud


def test_predictions_in_the_format_of_scannet(tmp_path: Path) -> None:
    listed, cloud = scannet(tmp_path, ["1\n1\n0\n0\n", "0\n1\n1\n0\n"])
    proposals = loaded(listed, cloud=str(cloud))
    assert np.allclose(proposals.points_world, POINTS)
    assert proposals.of_points().tolist() == [0, 0, 1, -1]
    assert proposals.label == ("5", "6")


def test_a_mask_of_another_cloud_is_refused(tmp_path: Path) -> None:
    listed, cloud = scannet(tmp_path, ["1\n0\n"])
    with pytest.raises(ValueError, match=r"mask_0\.txt: expected 4 numbers, got 2"):
        loaded(listed, cloud=str(cloud))


@pytest.mark.parametrize(
    ("params", "says"),
    [({"path": "masks.pth"}, "path must name"), ({"path": "masks.txt"}, "cloud must name")],
)
def test_parameters_are_checked_before_anything_is_read(params: dict[str, str], says: str) -> None:
    with pytest.raises(ParamError, match=says):
        build("proposals", {"kind": "file", **params})


def test_a_missing_file_is_said_when_the_source_is_made(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="path: no file"):
        build("proposals", {"kind": "file", "path": str(tmp_path / "none.npz")})


def test_the_example_in_the_documentation_works(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = (Path(__file__).parents[2] / "docs" / "proposals.md").read_text("utf-8")
    monkeypatch.chdir(tmp_path)
    exec(text.partition("```python")[2].partition("```")[0], {})
    proposals = loaded(tmp_path / "masks.npz")
    assert len(proposals.points_world) == 5000
    assert len(proposals.score) == 1
    assert 2000 < (proposals.of_points() == 0).sum() < 3000
