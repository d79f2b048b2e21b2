"""Which kind of recording a path is, by what lies there."""

from pathlib import Path


def kind_of(path: Path) -> str | None:
    """Return the source kind ``scannet``, ``replica`` or ``tum``; ``None`` = none of these.

    Only names of files are looked at: whether they are any good is found out by the source.
    """
    tests = {"scannet": _is_scannet, "replica": _is_replica, "tum": _is_tum}
    return next((kind for kind, test in tests.items() if test(path)), None)


def _is_scannet(path: Path) -> bool:
    extracted = all((path / part).is_dir() for part in ("color", "depth", "pose", "intrinsic"))
    return path.suffix == ".sens" or extracted or any(path.glob("*.sens"))


def _is_replica(path: Path) -> bool:
    return (path / "traj.txt").is_file() and (path / "results").is_dir()


def _is_tum(path: Path) -> bool:
    return (path / "rgb.txt").is_file() and (path / "depth.txt").is_file()
