"""Which kind of recording a path is, by what lies there."""

import sqlite3
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

OUR_LIBRARY, HEAD_BYTES = b"\x06\0\0\0sceneq", 64
"""The name as a text of MCAP: its length first."""
FRAMES = "frame-*.color.*"
MCAP, ROSBAG_1, SQLITE = b"\x89MCAP0\r\n", b"#ROSBAG V2.0", b"SQLite format 3\0"
EBML, ZIP = b"\x1aE\xdf\xa3", b"PK\x03\x04"


@dataclass(frozen=True, slots=True)
class Layout:
    """How a kind of recording is told from others; ``looked_for`` is that in words."""

    kind: str
    looked_for: str
    fits: Callable[[Path], bool]


def kind_of(path: Path) -> str | None:
    """Return the source kind of a recording; ``None`` = none of those known.

    Only names of files, their first bytes and the names of tables are looked at: whether they are
    any good is found out by the source.
    """
    return next((layout.kind for layout in LAYOUTS if layout.fits(path)), None)


def need_kind(path: Path) -> str:
    """Return the source kind of a recording; ``ValueError`` names all that was looked for."""
    if not path.exists():
        raise ValueError(f"{path}: no such file or folder; say where the recording is")
    kind = kind_of(path)
    if kind is None:
        raise ValueError(f"{path}: {_inside(path)}no frames in a layout that is known: {KNOWN}")
    return kind


def _inside(path: Path) -> str:
    """Tell of a folder of recordings which they are."""
    folders = sorted(p for p in path.iterdir() if p.is_dir()) if path.is_dir() else []
    inside = [folder.name for folder in folders if kind_of(folder) is not None]
    return f"{', '.join(inside[:3])} in it can be played, name one; itself has " if inside else ""


def _is_folder(path: Path) -> bool:
    return any(path.glob(FRAMES))


def _is_scannet(path: Path) -> bool:
    extracted = all((path / part).is_dir() for part in ("color", "depth", "pose", "intrinsic"))
    return path.suffix == ".sens" or extracted or any(path.glob("*.sens"))


def _is_replica(path: Path) -> bool:
    return (path / "traj.txt").is_file() and (path / "results").is_dir()


def _is_tum(path: Path) -> bool:
    return (path / "rgb.txt").is_file() and (path / "depth.txt").is_file()


def _is_kitti(path: Path) -> bool:
    return (path / "velodyne").is_dir() and (path / "calib.txt").is_file()


def _is_redwood(path: Path) -> bool:
    colors = (path / name for name in ("color", "rgb", "image"))
    return (path / "depth").is_dir() and any(folder.is_dir() for folder in colors)


def _is_r3d(path: Path) -> bool:
    return path.suffix == ".r3d" and _starts(path, ZIP)


def _is_rtabmap(path: Path) -> bool:
    return {"Node", "Data", "Admin"} <= _tables(path)


def _is_azure(path: Path) -> bool:
    return path.suffix == ".mkv" and _starts(path, EBML)


def _is_recording(path: Path) -> bool:
    """Look at who wrote the file: its first record, a header of two texts, says that."""
    if not _starts(path, MCAP):
        return False
    with path.open("rb") as file:
        return OUR_LIBRARY in file.read(HEAD_BYTES)


def _is_rosbag(path: Path) -> bool:
    if _starts(path, MCAP):
        return True
    is_ros2 = (path / "metadata.yaml").is_file() or {"topics", "messages"} <= _tables(path)
    return is_ros2 or _starts(path, ROSBAG_1)


def _starts(path: Path, signature: bytes) -> bool:
    if not path.is_file():
        return False
    with path.open("rb") as file:
        return file.read(len(signature)) == signature


def _tables(path: Path) -> set[str]:
    """Return the names of the tables of an SQLite file, none of anything else."""
    if not _starts(path, SQLITE):
        return set()
    file = sqlite3.connect(f"{path.resolve().as_uri()}?mode=ro", uri=True)
    try:
        return {name for (name,) in file.execute("SELECT name FROM sqlite_master")}
    except sqlite3.Error:
        return set()  # damaged beyond its first bytes: no layout fits
    finally:
        file.close()


LAYOUTS = (
    Layout("folder", "frame-000000.color.jpg, ... (7-Scenes, ours)", _is_folder),
    Layout("mcap", ".mcap (sceneq record)", _is_recording),
    Layout(
        "rosbag", ".bag (ROS 1), .mcap, .db3 or a folder with metadata.yaml (ROS 2)", _is_rosbag
    ),
    Layout("scannet", ".sens or color/, depth/, pose/, intrinsic/ (ScanNet)", _is_scannet),
    Layout("replica", "results/ and traj.txt (Replica)", _is_replica),
    Layout("tum", "rgb.txt and depth.txt (TUM RGB-D)", _is_tum),
    Layout("redwood", "depth/ and color/, rgb/ or image/ (Open3D, Redwood)", _is_redwood),
    Layout("r3d", ".r3d (Record3D)", _is_r3d),
    Layout("rtabmap", ".db with tables Node, Data, Admin (RTAB-Map)", _is_rtabmap),
    Layout("kitti", "image_2/, velodyne/ and calib.txt (KITTI odometry)", _is_kitti),
    Layout("azure", ".mkv (Azure Kinect)", _is_azure),
)
"""In the order in which they are tried."""
KNOWN = "; ".join(layout.looked_for for layout in LAYOUTS)
