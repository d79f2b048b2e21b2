"""Tiny furniture libraries in the format of Sweet Home 3D."""

from pathlib import Path
from zipfile import ZipFile

import cv2
import numpy as np

CATALOGUE = """# PluginFurnitureCatalog.properties
id=Test#Models
name=Test catalogue
license=CC0 \\u00a9 nobody

id#1=Test#stool
name#1=St\\u00fchlchen
model#1=/test/stool/stool.obj
width#1=40
depth#1=20
height#1=60
creator#1=Ann
"""

MATERIALS = """newmtl red
Kd 0.8 0.1 0.1
Ks 0.2 0.2 0.2
Ns 30
newmtl pictured
Kd 0 0 0
map_Kd wood.png
newmtl lost
Kd 0.2 0.6 0.2
map_Kd C:\\\\Users\\\\ann\\\\gone.png
newmtl glass
Tr 0.8
"""

BOX = """mtllib stool.mtl
v 0 0 0
v 1 0 0
v 1 2 0
v 0 2 0
v 0 0 1
v 1 0 1
v 1 2 1
v 0 2 1
vt 0 0
vt 1 0
vt 1 1
vt 0 1
usemtl red
f 1 4 3 2
f 5 6 7 8
usemtl pictured
f 1/1 2/2 6/3 5/4
f 4/1 8/2 7/3 3/4
usemtl lost
f -8 -4 -1 -5
usemtl glass
f 2 3 7 6
"""


def write_library(
    folder: Path,
    name: str = "Test.sh3f",
    catalogue: str = CATALOGUE,
    obj: str = BOX,
    mtl: str = MATERIALS,
) -> Path:
    """Write an archive with one model, two pictures and, if asked, broken texts."""
    path = folder / name
    with ZipFile(path, "w") as archive:
        archive.writestr("PluginFurnitureCatalog.properties", catalogue)
        archive.writestr("test/stool/stool.obj", obj)
        archive.writestr("test/stool/stool.mtl", mtl)
        archive.writestr("test/stool/wood.png", _png(1600, 800))
        archive.writestr("test/stool/other.png", _png(8, 8))
    return path


def _png(width: int, height: int) -> bytes:
    image = np.zeros((height, width, 3), dtype=np.uint8)
    image[:, :, 2] = 200  # blue, green, red: a red picture
    return bytes(cv2.imencode(".png", image)[1])
