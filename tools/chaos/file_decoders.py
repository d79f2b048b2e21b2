"""Decoders of files that a person names: recordings, parameters, graphs."""

import io
import json
import struct
import zipfile
import zlib
from collections.abc import Callable, Iterator
from importlib.resources import files
from pathlib import Path

import cv2
import numpy as np
import yaml

from sceneq_nodes._calibration import read_calibration
from sceneq_nodes._camera_files import read_color_camera, read_intrinsics, read_stamps_ns
from sceneq_nodes._chosen_calibration import SHIPPED
from sceneq_nodes._frame_files import BadFileError, FrameFiles, check_image
from sceneq_nodes._image_file import decode_depth_mm, decode_rgb
from sceneq_nodes._likeness_file import SHIPPED as LIKENESS
from sceneq_nodes._likeness_file import judgement_of
from sceneq_nodes._ply_file import read_vertices
from sceneq_nodes._probe_file import read_probe
from sceneq_nodes._proposal_file import ProposalFile, ProposalFileParams
from sceneq_nodes._sens_file import SensFile
from sceneq_tools.chaos.decoder import Decoder
from sceneq_tools.chaos.mutation import BYTES, JSON
from sceneq_tools.chaos.wire_decoders import SIZE, small_frame
from sceneq_tools.errors import UserError
from sceneq_tools.graph import load

Read = Callable[[Path], object]
REFUSALS = (ValueError, BadFileError, UserError)
FRAMES = [0, 1, 2]


def file_decoders(folder: Path) -> Iterator[Decoder]:
    """Yield a decoder for every kind of file; each writes its input below ``folder`` first."""
    sample = Path(str(files("sceneq_tools"))) / "sample"
    graph = Path(str(files("sceneq_tools"))) / "graph.yaml"
    intrinsics, pose = (
        (sample / name).read_bytes() for name in ("camera-intrinsics.txt", "frame-000000.pose.txt")
    )
    calibration = sorted(SHIPPED.glob("*.json"))[0].read_bytes()
    for name, read, seeds, form, file in (
        ("colour image", _colour, _colours(), BYTES, "frame-000000.color.png"),
        ("depth image", _depth, _depths(), BYTES, "frame-000000.depth.png"),
        ("pose", _pose, (pose,), BYTES, "frame-000000.pose.txt"),
        ("intrinsics", _intrinsics, (intrinsics,), BYTES, "camera-intrinsics.txt"),
        ("colour camera", _camera, (_CAMERA,), JSON, "camera-color.json"),
        ("stamps", _stamps, (b"0.0\n0.1\n0.25\n",), BYTES, "stamps.txt"),
        ("ScanNet container", _sens, (sens_bytes(),), BYTES, "scene.sens"),
        ("PLY cloud", read_vertices, _plys(), BYTES, "cloud.ply"),
        ("proposals", _proposals, _proposal_seeds(), BYTES, "masks.npz"),
        ("calibration", read_calibration, (calibration,), JSON, "calibration.json"),
        ("likeness", _likeness, (LIKENESS.read_bytes(),), JSON, "likeness.json"),
        ("probe", read_probe, (small_probe(),), BYTES, "probe.npz"),
        ("graph", load, (graph.read_bytes(), _GRAPH), BYTES, "graph.yaml"),
    ):
        path = folder / name.replace(" ", "-") / file
        path.parent.mkdir()
        yield Decoder(f"file: {name}", reading(path, read), seeds, form, REFUSALS)
    mended = folder / "mended"
    mended.mkdir()
    for name, read, seeds, mend, file in (
        ("colour image", _colour, _colours()[:1], with_checksums, "frame-000000.color.png"),
        ("depth image", _depth, _depths(), with_checksums, "frame-000000.depth.png"),
        ("proposals", _proposals, _columns(), _npz_of, "masks.npz"),
    ):
        decode = reading(mended / file, read, mend)
        yield Decoder(f"file: {name}, checksums right", decode, seeds, BYTES, REFUSALS)


def reading(
    path: Path, read: Read, mend: Callable[[bytes], bytes] = bytes
) -> Callable[[bytes], object]:
    """Return what reads its input from the file ``path``, written there ``mend``-ed."""

    def decode(data: bytes) -> object:
        path.write_bytes(mend(data))
        return read(path)

    return decode


def with_checksums(png: bytes) -> bytes:
    """Return a PNG with the checksums that its chunks should have, as far as they go."""
    data, at = bytearray(png), 8
    while at + 12 <= len(data):
        end = at + 8 + int.from_bytes(data[at : at + 4], "big")
        if end + 4 <= len(data):
            data[end : end + 4] = zlib.crc32(data[at + 4 : end]).to_bytes(4, "big")
        at = end + 4
    return bytes(data)


def _colour(path: Path) -> None:
    data = path.read_bytes()
    check_image(path, data, "color")
    decode_rgb(data)


def _depth(path: Path) -> None:
    data = path.read_bytes()
    check_image(path, data, "depth")
    decode_depth_mm(data)


def _pose(path: Path) -> object:
    path.with_name("frame-000000.depth.png").touch()
    return FrameFiles(path.parent).pose(0)


def _intrinsics(path: Path) -> object:
    return read_intrinsics(path.parent)


def _camera(path: Path) -> object:
    return read_color_camera(path.parent)


def _stamps(path: Path) -> object:
    return read_stamps_ns(path.parent, FRAMES)


def _sens(path: Path) -> None:
    file = SensFile(path)
    for number in file.numbers[:2]:
        file.pose(number)
        decode_rgb(file.image(number, "color")[0])
        file.decode_depth_mm(file.image(number, "depth")[0])


def _proposals(path: Path) -> object:
    return ProposalFile(ProposalFileParams(str(path))).load()


def _likeness(path: Path) -> object:
    return judgement_of("hash-v1", str(path))


def _colours() -> tuple[bytes, ...]:
    rgb = small_frame().rgb
    return tuple(cv2.imencode(end, rgb)[1].tobytes() for end in (".png", ".jpg"))


def _depths() -> tuple[bytes, ...]:
    depth_mm = (small_frame().depth_m * 1000).astype(np.uint16)
    return (cv2.imencode(".png", depth_mm)[1].tobytes(),)


def sens_bytes() -> bytes:
    """Return a ScanNet container of one small frame."""
    height, width = SIZE
    depth = zlib.compress(np.full(SIZE, 900, "<u2").tobytes())
    colour, unit = _colours()[1], np.eye(4, dtype="<f4").tobytes()
    head = struct.pack("<IQ", 4, 5) + b"Kinet" + unit * 4
    head += struct.pack("<iiIIIIfQ", 2, 1, width, height, width, height, 1000.0, 1)
    frame = unit + struct.pack("<QQQQ", 10, 10, len(colour), len(depth))
    return head + frame + colour + depth


def _plys() -> tuple[bytes, ...]:
    head = "ply\nformat {}\nelement vertex 2\n"
    axes = "".join(f"property float {axis}\n" for axis in "xyz") + "end_header\n"
    points = np.arange(6, dtype="<f4").tobytes()
    binary = (head.format("binary_little_endian 1.0") + axes).encode() + points
    return binary, (head.format("ascii 1.0") + axes + "0 1 2\n3 4 5\n").encode()


def _columns() -> tuple[bytes, ...]:
    columns = (np.zeros((4, 3), np.float32), np.array([0, 1], np.int32), np.array(["a", "b"]))
    return tuple(_npy(column) for column in columns)


def _npy(array: object) -> bytes:
    file = io.BytesIO()
    np.save(file, array)  # type: ignore[arg-type]
    return file.getvalue()


def _npz_of(column: bytes) -> bytes:
    """Return a file of proposals whose points and masks are all the same damaged column."""
    file = io.BytesIO()
    good = {"mask_id": np.array([0, 1]), "point_id": np.array([0, 1]), "score": np.ones(2)}
    with zipfile.ZipFile(file, "w") as archive:
        for name in ("points_world", *good):
            use_bad = name == "points_world" or column[-1:] == name[-1:].encode()
            archive.writestr(f"{name}.npy", column if use_bad else _npy(good[name]))
    return file.getvalue()


def _npz(**arrays: object) -> bytes:
    file = io.BytesIO()
    np.savez(file, **arrays)  # type: ignore[arg-type]
    return file.getvalue()


def _proposal_seeds() -> tuple[bytes, ...]:
    points_world = np.zeros((4, 3), np.float32)
    ids = np.array([0, 1], np.int32)
    pairs = {"mask_id": ids, "point_id": ids, "score": np.ones(2), "label": np.array(["a", "b"])}
    instance = np.array([0, 1, 1, 2], np.int32)
    return (
        _npz(points_world=points_world, **pairs),
        _npz(points_world=points_world, instance=instance),
    )


def small_probe() -> bytes:
    """Return a file like the one that comes with the program, with two names."""
    return _npz(
        names=np.array(["mug", "cup"]),
        weights=np.ones((4, 2), np.float16),
        bias=np.zeros(2, np.float32),
        size_mean=np.zeros((2, 4), np.float32),
        size_spread=np.ones((2, 4), np.float32),
        texts=np.array(["a mug", "a cup"]),
        text_vectors=np.ones((2, 384), np.float16),
        text_of=np.array([0, 1], np.int32),
        taught_with=np.array("0123"),
    )


_CAMERA = json.dumps({"K": np.eye(3).tolist(), "T_color_depth": np.eye(4).tolist()}).encode()
_GRAPH = yaml.safe_dump(
    {
        "scene": "room",
        "router": {"listen": ["tcp/127.0.0.1:7447"], "connect": []},
        "watchdog": {"silent_s": 3.0},
        "nodes": [{"id": "mapping", "params": {"mapper": {"voxel_size_m": 0.02}}}],
    }
).encode()
