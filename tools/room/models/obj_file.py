"""Wavefront OBJ text as arrays, before anything is known of units, materials or frames."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Bool, Float64, Int64
from sceneq_tools.room.models.obj_numbers import CornerTokens, NumberRows, whole_number


@dataclass(frozen=True, slots=True, eq=False)
class ObjFile:
    """What an OBJ file says.

    Attributes:
        positions: float64 (V, 3), ``uv``: (T, 2), ``normals``: (N, 3), as written.
        corners: int64 (C, 3) indices of position, uv and normal, -1 where absent; all faces'
            corners one after another.
        sizes: int64 (F,) corners of each face, at least 3.
        material_index: int64 (F,) into ``material_names``.
        smooth: bool (F,) false for faces under ``s off``.
        material_files: names of MTL files, in the order they are named.
    """

    positions: Float64
    uv: Float64
    normals: Float64
    corners: Int64
    sizes: Int64
    material_index: Int64
    smooth: Bool
    material_names: tuple[str, ...]
    material_files: tuple[str, ...]


def parse_obj(text: str) -> ObjFile:
    """Read an OBJ file's text.

    Raises:
        ValueError: a number that is none or an index that points nowhere; the message starts with
            ``line N:``.
    """
    reader = _Reader()
    for number, line in enumerate(text.splitlines(), 1):
        words = line.split(None, 1)
        handle = reader.handlers.get(words[0]) if words else None
        if handle is not None:
            handle(words[1] if len(words) > 1 else "", number)
    return reader.finished()


class _Reader:
    def __init__(self) -> None:
        self.positions = NumberRows(3)
        self.uv = NumberRows(2, padding=" 0")
        self.normals = NumberRows(3)
        self.faces = CornerTokens()
        self.material_of_face: list[int] = []
        self.smooth_of_face: list[bool] = []
        self.materials: dict[str, int] = {}
        self.material = self._material("")
        self.smooth = True
        self.files: list[str] = []
        self.handlers: dict[str, Callable[[str, int], None]] = {
            "v": self.positions.append,
            "vt": self.uv.append,
            "vn": self.normals.append,
            "f": self._face,
            "s": self._smoothing,
            "usemtl": self._use,
            "mtllib": self._file,
        }

    def _face(self, text: str, line: int) -> None:
        tokens = text.split()
        if len(tokens) < 3:
            return  # loose edges are written as faces, too
        if "-" in text:
            tokens = [self._counted(token, line) for token in tokens]
        self.faces.append(tokens, line)
        self.material_of_face.append(self.material)
        self.smooth_of_face.append(self.smooth)

    def _counted(self, token: str, line: int) -> str:
        """A corner with negative indices, counted from what has been read so far."""
        words = token.split("/")
        for place, rows in enumerate((self.positions, self.uv, self.normals)[: len(words)]):
            if words[place].startswith("-"):
                words[place] = str(len(rows.texts) + 1 + whole_number(words[place], line))
        return "/".join(words)

    def _smoothing(self, text: str, line: int) -> None:
        self.smooth = text.strip() not in ("off", "0")

    def _use(self, text: str, line: int) -> None:
        self.material = self._material(text.strip())

    def _file(self, text: str, line: int) -> None:
        self.files.append(text.strip())

    def _material(self, name: str) -> int:
        return self.materials.setdefault(name, len(self.materials))

    def finished(self) -> ObjFile:
        positions, uv, normals = self.positions.array(), self.uv.array(), self.normals.array()
        corners = self.faces.array() - 1
        self._check(corners, (len(positions), len(uv), len(normals)))
        return ObjFile(
            positions=positions,
            uv=uv,
            normals=normals,
            corners=corners,
            sizes=np.array(self.faces.sizes, dtype=np.int64),
            material_index=np.array(self.material_of_face, dtype=np.int64),
            smooth=np.array(self.smooth_of_face, dtype=bool),
            material_names=tuple(self.materials),
            material_files=tuple(self.files),
        )

    def _check(self, corners: Int64, counts: tuple[int, int, int]) -> None:
        wrong = (corners >= np.array(counts)) | (corners < np.array([0, -1, -1]))
        if not wrong.any():
            return
        at = int(np.flatnonzero(wrong.any(axis=1))[0])
        have = "{} positions, {} texture coordinates and {} normals".format(*counts)
        token, line = self.faces.tokens[at], self.faces.line(at)
        raise ValueError(f"line {line}: corner {token} points outside {have}")
