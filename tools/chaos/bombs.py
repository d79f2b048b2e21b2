"""Inputs made to hurt: a few bytes that claim gigabytes, nest without end, or are no numbers.

Each must be refused, or answered, in bounded memory and time. ``python -m sceneq_tools.chaos.bombs
FOLDER`` is the process in which that is done, a line of JSON for every bomb.
"""

import json
import os
import struct
import subprocess
import sys
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import msgpack
import numpy as np
import zstandard

from sceneq_schemas.codec import encode
from sceneq_schemas.frame import Frame, ImageData
from sceneq_tools.chaos.decoders import decoders
from sceneq_tools.chaos.examples import EXAMPLES
from sceneq_tools.chaos.file_decoders import sens_bytes
from sceneq_tools.chaos.fuzz import MEMORY_MB, outcome
from sceneq_tools.chaos.fuzz_worker import feed, limit_memory
from sceneq_tools.chaos.scenario import Outcome, Plan
from sceneq_tools.chaos.small_scene import map_of
from sceneq_tools.chaos.wire_decoders import small_frame

DEEP = 100_000
SIDE = 30_000
QUESTION_BYTES = 60_000
HARMLESS = frozenset({"long question", "endless question"})
"""These are fine questions; they only must not take long."""

Bomb = tuple[str, bytes]
"""The name of a decoder and what it is given."""


def run(plan: Plan) -> Iterator[Outcome]:
    """Yield one outcome for every bomb."""
    folder = plan.work / "bombs"
    folder.mkdir()
    command = [sys.executable, "-m", "sceneq_tools.chaos.bombs", str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    for line in done.stdout.splitlines():
        yield judged(json.loads(line))
    if done.returncode:
        yield Outcome("bombs", 1, "the process", False, f"ended with code {done.returncode}")


def judged(result: dict[str, Any]) -> Outcome:
    """Return the outcome of a bomb: to accept one is as bad as to fall over it."""
    told = outcome(result)
    taken = result["accepted"] and result["decoder"] not in HARMLESS
    fault = f"bomb: {result['decoder']}"
    return replace(told, fault=fault, passed=told.passed and not taken)


def main(folder: Path) -> None:
    """Throw every bomb at its decoder."""
    known = {decoder.name: decoder for decoder in decoders(folder)}
    limit_memory(MEMORY_MB)
    for name, (decoder, data) in bombs().items():
        result = feed(known[decoder], [data])
        print(json.dumps({**result, "decoder": name}), flush=True)
    os._exit(0)  # threads of nodes are of no more use


def bombs() -> Mapping[str, Bomb]:
    """Return them all by name."""
    return {**_images(), **_structures(), **_numbers(), **_texts(), **_files()}


def _images() -> dict[str, Bomb]:
    jpeg = cv2.imencode(".jpg", small_frame().rgb)[1].tobytes()
    at = jpeg.index(b"\xff\xc0") + 5
    large = jpeg[:at] + struct.pack(">HH", SIDE, SIDE) + jpeg[at + 4 :]
    huge = jpeg[:at] + b"\xff\xff\xff\xff" + jpeg[at + 4 :]
    lies = zstandard.ZstdCompressor(write_content_size=False).compress(bytes(1 << 20))
    return {
        "JPEG of 30000 x 30000 in a frame": _image("jpeg", large),
        "JPEG of 65535 x 65535 in a frame": _image("jpeg", huge, (65535, 65535, 3)),
        "JPEG of 30000 x 30000 as a question": ("payload picture", large),
        "PNG of 30000 x 30000 as a question": ("payload picture", _png(2, 8)),
        "JPEG of 30000 x 30000 in a recording": ("file: colour image", large),
        "PNG of 30000 x 30000 in a recording": ("file: colour image", _png(2, 8)),
        "depth PNG of 30000 x 30000": ("file: depth image", _png(0, 16)),
        "zstd frame that claims 100 GB": _image("zstd", _zstd_claiming(100 << 30)),
        "zstd frame that claims what its shape says": _image(
            "zstd", _zstd_claiming(16384 * 16384 * 3), (16384, 16384, 3)
        ),
        "zstd frame without a size": _image("zstd", lies, (1024, 341, 3)),
        "raw image of an absurd shape": _image("raw", b"\x00" * 64, (2**31, 2**31, 3)),
        "image of a negative shape": _image("raw", b"\x00" * 64, (-4, -4, 3)),
        "image of objects": ("image", encode(ImageData("raw", "|O", (2, 3, 3), b"\x00" * 18))),
    }


def _structures() -> dict[str, Bomb]:
    array = {"dt": "<u2", "sh": [3, 4], "b": bytes(24)}
    masks = {"seq": 7, "stamp_ns": 1, "label_image": array}

    def of_array(**changes: Any) -> Bomb:
        return "topic mask", msgpack.packb({**masks, "label_image": {**array, **changes}})

    return {
        "msgpack lists nested 100 000 deep": ("topic map_delta", b"\x91" * DEEP),
        "msgpack maps nested 100 000 deep": ("topic map_delta", b"\x81\xa1b" * DEEP),
        "msgpack list of 4 000 000 000": ("topic map_delta", b"\xdd\xff\xff\xff\xff"),
        "lists in lists that claim the most each": (
            "topic map_delta",
            (b"\xdd" + struct.pack(">I", 16_384)) * 13_000,
        ),
        "msgpack text of 4 GB": ("topic mask", b"\x81\xa3seq\xdb\xff\xff\xff\xff"),
        "msgpack text of 1 MB": ("topic mask", msgpack.packb({**masks, "x": "x" * 1_000_000})),
        "array of objects": of_array(dt="|O"),
        "array of a negative shape": of_array(sh=[-3, -4]),
        "array of an absurd shape": of_array(sh=[2**31 - 1, 2**31 - 1]),
        "array whose size overflows": of_array(sh=[2**31, 2**31, 2**31, 2**31]),
        "array with a shape of texts": of_array(sh=["3", "4"]),
        "one voxel with the highest id": _map(voxel_id=np.array([2**26 - 1], np.int32), rows=1),
        "one instance with the highest superpoint": _map(superpoint=2**26 - 1),
        "instance number 2^31": _map(instance_id=2**31),
        "instance number -1": _map(instance_id=-1),
        "JSON nested 100 000 deep": ("any JSON topic", b"[" * DEEP),
        "JSON number of 60 000 digits": ("any JSON topic", b"9" * 60_000),
        "question of JSON nested 12 000 deep": ("payload JSON", b'{"q":' * 12_000),
        "question of msgpack nested 60 000 deep": ("payload msgpack", b"\x91" * 60_000),
    }


def _numbers() -> dict[str, Bomb]:
    frame = next(one for one in EXAMPLES if isinstance(one, Frame))
    poses = {"NaN": np.full((4, 4), np.nan), "infinite": np.full((4, 4), np.inf)}
    poses |= {"zero": np.zeros((4, 4)), "huge": np.eye(4) * 1e308}
    found = {
        f"{name} pose": ("topic frame", encode(replace(frame, T_world_camera=pose)))
        for name, pose in poses.items()
    }
    K = {"NaN": np.full((3, 3), np.nan), "zero": np.zeros((3, 3))}
    found |= {
        f"{name} intrinsics": ("topic frame", encode(replace(frame, K=k))) for name, k in K.items()
    }
    return {
        **found,
        "surface that is not finite": _map(
            voxel_id=np.zeros(1, np.int32), rows=1, point=float("nan")
        ),
        "voxels of no size": _map(voxel_size_m=0.0),
        "voxels of infinite size": _map(voxel_size_m=float("inf")),
    }


def _texts() -> dict[str, Bomb]:
    many = b"the mug on the table and " * (QUESTION_BYTES // 25)
    deep = b"the mug on the table next to the " * (QUESTION_BYTES // 33)
    return {
        "question of 1 MB": ("payload text", b"x" * 1_000_000),
        "long question": ("payload text", many),
        "endless question": ("payload text", deep),
        "name of 60 000 characters": ("selector of set", b"id=1;name=" + b"x" * 60_000),
        "question that is no text": ("payload text", b"\xff\xfe\xfd" * 100),
    }


def _files() -> dict[str, Bomb]:
    laughs = b"a: &a [x,x,x,x,x,x,x,x,x]\n" + b"".join(
        b"%c: &%c [*%c,*%c,*%c,*%c,*%c,*%c,*%c,*%c,*%c]\n" % (k + 1, k + 1, *[k] * 9)
        for k in range(ord("a"), ord("o"))
    )
    return {
        "graph of aliases (billion laughs)": ("file: graph", laughs),
        "graph nested 20 000 deep": ("file: graph", b"nodes: " + b"[" * 20_000),
        "npz that unpacks to 4 GB": ("file: proposals", _npz_claiming(4 << 30)),
        "npz column that claims 100 GB": (
            "file: proposals, checksums right",
            _npy_claiming(25 << 30),
        ),
        "zlib depth that unpacks to 64 MB, not 1.5 kB": ("file: ScanNet container", _sens_bomb()),
        "PLY of 10^18 vertices": (
            "file: PLY cloud",
            b"ply\nformat binary_little_endian 1.0\nelement vertex 1000000000000000000\n"
            b"property float x\nproperty float y\nproperty float z\nend_header\n" + bytes(24),
        ),
        "state that claims 10 GB": (
            "content of a checkpoint",
            _state_of([["<f8", [1 << 30]]]),
        ),
        "state with an array of objects": ("content of a checkpoint", _state_of([["|O", [4]]])),
    }


def _image(codec: str, data: bytes, shape: tuple[int, ...] = (SIDE, SIDE, 3)) -> Bomb:
    return "image", encode(ImageData(codec, "|u1", shape, data))


def _png(colour_type: int, bits: int) -> bytes:
    """Return a PNG whose header says ``SIDE`` squared, with a hundredth of its rows."""
    channels = 3 if colour_type == 2 else 1
    row = bytes(1 + SIDE * channels * bits // 8)
    deflate = zlib.compressobj(9)
    body = b"".join(deflate.compress(row) for _ in range(SIDE // 100)) + deflate.flush()
    head = struct.pack(">IIBBBBB", SIDE, SIDE, bits, colour_type, 0, 0, 0)
    chunks = ((b"IHDR", head), (b"IDAT", body), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        for kind, data in chunks
    )


def _zstd_claiming(size: int) -> bytes:
    """Return a zstd frame whose header promises ``size`` bytes; one empty block follows."""
    return b"\x28\xb5\x2f\xfd" + b"\xe0" + struct.pack("<Q", size) + b"\x01\x00\x00"


def _map(
    voxel_id: Any = None,
    rows: int = 0,
    point: float = 0.0,
    superpoint: int = 0,
    instance_id: int = 1,
    voxel_size_m: float = 0.02,
) -> Bomb:
    whole = map_of(1)
    ids = np.array([superpoint], np.int32)
    instance = replace(whole.instances[0], superpoint_id=ids, instance_id=instance_id)
    voxels: dict[str, Any] = {
        "voxel_id": np.zeros(0, np.int32) if voxel_id is None else voxel_id,
        "voxel_coord": np.zeros((rows, 3), np.int32),
        "points_world": np.full((rows, 3), point, np.float32),
        "rgb": np.zeros((rows, 3), np.uint8),
        "superpoint_id": np.zeros(rows, np.int32),
    }
    return "topic map_delta", encode(
        replace(whole, instances=(instance,), voxel_size_m=voxel_size_m, **voxels)
    )


def _npy_claiming(count: int) -> bytes:
    head = f"{{'descr': '<f4', 'fortran_order': False, 'shape': ({count},), }}".encode()
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(head)) + head


def _npz_claiming(size: int) -> bytes:
    """Return an archive whose directory says that a member unpacks to ``size`` bytes."""
    name = b"points_world.npy"
    sizes = struct.pack("<IIII", 0, 8, min(size, 2**32 - 2), 0)[:12]
    local = b"PK\x03\x04" + struct.pack("<HHHHH", 20, 0, 8, 0, 0) + sizes
    local += struct.pack("<HH", len(name), 0) + name + bytes(8)
    entry = b"PK\x01\x02" + struct.pack("<HHHHHH", 20, 20, 0, 8, 0, 0) + sizes
    entry += struct.pack("<HHHHHII", len(name), 0, 0, 0, 0, 0, 0) + name
    end = b"PK\x05\x06" + struct.pack("<HHHHIIH", 0, 0, 1, 1, len(entry), len(local), 0)
    return local + entry + end


def _sens_bomb() -> bytes:
    depth = zlib.compress(bytes(1 << 30 >> 4), 9)
    whole = sens_bytes()
    good = zlib.compress(np.full((24, 32), 900, "<u2").tobytes())
    at = whole.rindex(struct.pack("<Q", len(good)))
    return whole[:at] + struct.pack("<Q", len(depth)) + whole[at + 8 : -len(good)] + depth


def _state_of(arrays: list[list[Any]]) -> bytes:
    told = json.dumps({"parts": [], "arrays": arrays}).encode()
    return struct.pack("<Q", len(told)) + told + bytes(64)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
