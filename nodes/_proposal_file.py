"""3D masks from a file: an .npz of ours, or predictions in the text format of ScanNet."""

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

from sceneq_core.arrays import Array, Float32
from sceneq_core.mapping.proposals import Proposals
from sceneq_nodes._npz_file import read_arrays
from sceneq_nodes._ply_file import read_vertices

MAX_MB = 1024
"""Ten million points with their masks take a quarter of it."""


@dataclass(frozen=True, slots=True)
class ProposalFileParams:
    """``path``: an .npz, or a .txt of ScanNet whose masks are over the vertices of ``cloud``."""

    path: str
    cloud: str = ""

    def __post_init__(self) -> None:
        if Path(self.path).suffix not in (".npz", ".txt"):
            raise ValueError(f"path must name an .npz or .txt file, got {self.path!r}")
        if Path(self.path).suffix == ".txt" and not self.cloud:
            raise ValueError("cloud must name the .ply whose vertices the masks of the .txt are of")


class ProposalFile:
    """Reads the file once, before the first frame. The format: docs/proposals.md."""

    Params: ClassVar[type] = ProposalFileParams

    def __init__(self, params: ProposalFileParams) -> None:
        """Note where the file is; raise ``ValueError`` when it does not exist."""
        self._path, self._cloud = Path(params.path), Path(params.cloud)
        if not self._path.is_file():
            raise ValueError(f"path: no file {self._path}")

    def load(self) -> Proposals:
        """Return the proposals of the file.

        Raises:
            ValueError: what is there is no proposals; the message names the file and the field.
        """
        try:
            if self._path.suffix == ".npz":
                return _from_npz(self._path)
            return _from_scannet(self._path, self._cloud)
        except (OSError, ValueError) as error:
            raise ValueError(f"{self._path}: {error}") from error


def _from_npz(path: Path) -> Proposals:
    fields = read_arrays(path, MAX_MB)
    points_world = _field(fields, "points_world", "f")
    if "instance" in fields:
        mask_id, point_id = _pairs_of(_field(fields, "instance", "iu"), len(points_world))
    else:
        mask_id, point_id = (_field(fields, name, "iu") for name in ("mask_id", "point_id"))
    masks = int(mask_id.max(initial=-1)) + 1
    score = _field(fields, "score", "fiu") if "score" in fields else np.ones(masks)
    label = tuple(_field(fields, "label", "U").tolist()) if "label" in fields else ()
    return _proposals(points_world, mask_id, point_id, score, label)


def _field(fields: dict[str, Array], name: str, kinds: str) -> Array:
    if name not in fields:
        raise ValueError(f"{name}: missing, there are {', '.join(sorted(fields)) or 'no fields'}")
    if fields[name].dtype.kind not in kinds:
        raise ValueError(f"{name}: cannot be {fields[name].dtype}")
    return fields[name]


def _pairs_of(instance: Array, points: int) -> tuple[Array, Array]:
    """Return (mask, point) pairs of a number per point, 0 = none."""
    if instance.shape != (points,):
        raise ValueError(f"instance: expected ({points},), got {instance.shape}")
    point_id = np.flatnonzero(instance > 0)
    _, mask_id = np.unique(instance[point_id], return_inverse=True)
    return mask_id, point_id


def _from_scannet(path: Path, cloud: Path) -> Proposals:
    """Read lines of mask file (one number per vertex, 0 = outside), label number and score."""
    points_world = _vertices(cloud)
    rows = [line.split() for line in path.read_text("utf-8").splitlines() if line.strip()]
    for number, row in enumerate(rows, 1):
        if len(row) != 3:
            raise ValueError(f"line {number}: expected mask file, label and score, got {row}")
    inside = [np.flatnonzero(_mask(path.parent / row[0], len(points_world))) for row in rows]
    mask_id = np.repeat(np.arange(len(rows)), [len(points) for points in inside])
    score = np.array([float(row[2]) for row in rows])
    point_id = np.concatenate([*inside, np.zeros(0, np.int64)])
    return _proposals(points_world, mask_id, point_id, score, tuple(row[1] for row in rows))


def _vertices(cloud: Path) -> Float32:
    try:
        return read_vertices(cloud)
    except ValueError as error:
        raise ValueError(f"{cloud}: {error}") from error


def _mask(path: Path, points: int) -> Array:
    mask = np.array(path.read_text("ascii").split(), np.float64)
    if len(mask) != points:
        raise ValueError(f"{path.name}: expected {points} numbers, got {len(mask)}")
    return mask > 0


def _proposals(
    points_world: Array, mask_id: Array, point_id: Array, score: Array, label: tuple[str, ...]
) -> Proposals:
    return Proposals(
        points_world.astype(np.float32),
        mask_id.astype(np.int32),
        point_id.astype(np.int32),
        score.astype(np.float32),
        label,
    )
