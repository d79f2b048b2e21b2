"""One ``.sh3f`` archive: its catalogue, its model files and their pictures."""

import posixpath
from pathlib import Path
from zipfile import BadZipFile, ZipFile

import cv2
import numpy as np

from sceneq_core.arrays import Array, UInt8
from sceneq_tools.room.models.furniture_catalogue import CATALOGUE_FILE, Catalogue, parse_catalogue
from sceneq_tools.room.models.mtl_file import ObjMaterial, parse_mtl
from sceneq_tools.room.models.obj_file import ObjFile, parse_obj

_PICTURES = (".jpg", ".jpeg", ".png", ".bmp", ".gif")


class Archive:
    """Reads one library; what was read is not kept, except pictures.

    Raises:
        ValueError: from every method, when something cannot be read; names the archive's file, the
            member and, in texts, the line.
    """

    def __init__(self, path: Path, max_picture_px: int = 768) -> None:
        self.path = path
        self._max_picture_px = max_picture_px
        self._pictures: dict[str, UInt8 | None] = {}
        try:
            self._zip = ZipFile(path)
        except (BadZipFile, OSError) as error:
            raise ValueError(f"{path}: no readable archive: {error}") from error
        self._names = {name.lower(): name for name in self._zip.namelist()}

    def catalogue(self) -> Catalogue:
        """Return the table of contents."""
        try:
            return parse_catalogue(self._text(CATALOGUE_FILE))
        except ValueError as error:
            raise self._error(CATALOGUE_FILE, error) from error

    def model(self, member: str) -> tuple[ObjFile, dict[str, ObjMaterial]]:
        """Return an OBJ file and the materials it names; a missing MTL file has no materials."""
        try:
            obj = parse_obj(self._text(member))
        except ValueError as error:
            raise self._error(member, error) from error
        folder = posixpath.dirname(member)
        materials: dict[str, ObjMaterial] = {}
        for name in obj.material_files:
            materials |= self._materials(posixpath.join(folder, name))
        return obj, materials

    def picture(self, folder: str, written: str) -> UInt8 | None:
        """Return the picture named in an MTL file of ``folder`` as (h, w, 4) sRGB + alpha.

        Some authors left the paths of their own disks: then the picture of that name in the folder
        is taken, or the folder's only picture; ``None`` when there is neither.
        """
        member = self._picture_member(folder, written)
        if member is None:
            return None
        if member not in self._pictures:
            self._pictures[member] = self._decoded(member)
        return self._pictures[member]

    def _materials(self, member: str) -> dict[str, ObjMaterial]:
        if member.lower() not in self._names:
            return {}
        try:
            return parse_mtl(self._text(member))
        except ValueError as error:
            raise self._error(member, error) from error

    def _picture_member(self, folder: str, written: str) -> str | None:
        exact = posixpath.normpath(posixpath.join(folder, written))
        if exact.lower() in self._names:
            return self._names[exact.lower()]
        near = [
            name
            for lower, name in sorted(self._names.items())
            if lower.startswith(folder.lower() + "/") and lower.endswith(_PICTURES)
        ]
        wanted = posixpath.basename(written).lower()
        same = [name for name in near if posixpath.basename(name).lower() == wanted]
        if same:
            return same[0]
        return near[0] if len(near) == 1 else None

    def _decoded(self, member: str) -> UInt8:
        encoded = np.frombuffer(self._bytes(member), dtype=np.uint8)
        image = cv2.imdecode(encoded, cv2.IMREAD_UNCHANGED)
        if image is None:
            raise ValueError(f"{self.path.name}: {member}: not a picture that can be read")
        return _limited(_rgba(np.asarray(image)), self._max_picture_px)

    def _text(self, member: str) -> str:
        return self._bytes(member).decode("latin-1").replace("\\\r\n", " ").replace("\\\n", " ")

    def _bytes(self, member: str) -> bytes:
        name = self._names.get(member.lower())
        if name is None:
            raise ValueError(f"{self.path.name}: no file {member}")
        try:
            return self._zip.read(name)
        except (BadZipFile, OSError) as error:
            raise self._error(member, error) from error

    def _error(self, member: str, error: Exception) -> ValueError:
        message = str(error)
        if message.startswith(self.path.name):
            return ValueError(message)
        return ValueError(f"{self.path.name}: {member}: {message}")


def _rgba(image: Array) -> UInt8:
    if image.dtype != np.uint8:
        image = (image >> 8).astype(np.uint8)
    if image.ndim == 2:
        return np.asarray(cv2.cvtColor(image, cv2.COLOR_GRAY2RGBA), dtype=np.uint8)
    code = cv2.COLOR_BGRA2RGBA if image.shape[2] == 4 else cv2.COLOR_BGR2RGBA
    return np.asarray(cv2.cvtColor(image, code), dtype=np.uint8)


def _limited(image: UInt8, largest: int) -> UInt8:
    factor = largest / max(image.shape[:2])
    if factor >= 1:
        return image
    size = (max(1, round(image.shape[1] * factor)), max(1, round(image.shape[0] * factor)))
    return np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)
