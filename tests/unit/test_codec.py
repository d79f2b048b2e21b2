"""What the codec accepts, refuses and says about it."""

from dataclasses import dataclass, replace
from typing import Annotated, Any

import msgpack
import numpy as np
import pytest

from sceneq_schemas.arrays import Array, ArraySpec, brief, pack_array, unpack_array
from sceneq_schemas.codec import MAX_LIST, MAX_TEXT, decode, encode
from sceneq_schemas.errors import DecodeError
from sceneq_schemas.frame import ImageData, Pose

from support.messages import EXAMPLES, T_WORLD_CAMERA, same

POSE = next(m for m in EXAMPLES if isinstance(m, Pose))
SPEC = ArraySpec("<i4", (None, 2))


@dataclass(frozen=True, slots=True)
class Sample:
    """One field of every kind."""

    number: int
    ratio: float
    flag: bool
    text: str
    blob: bytes
    maybe: int | None = None
    items: tuple[int, ...] = ()
    table: dict[str, float] | None = None


SAMPLE = Sample(1, 0.5, True, "ü", b"\x00", None, (1, 2), {"a": 1.5})


def wire_of(message: Any) -> dict[str, Any]:
    wire: dict[str, Any] = msgpack.unpackb(encode(message))
    return wire


def changed(message: Any, **values: Any) -> bytes:
    data: bytes = msgpack.packb(wire_of(message) | values)
    return data


@pytest.mark.parametrize("message", EXAMPLES, ids=lambda m: type(m).__name__)
def test_examples_come_back(message: Any) -> None:
    assert same(decode(type(message), encode(message)), message)


def test_every_kind_of_field_comes_back() -> None:
    assert decode(Sample, encode(SAMPLE)) == SAMPLE


def test_fields_of_a_later_minor_version_are_ignored() -> None:
    assert decode(Sample, changed(SAMPLE, added_later=[1, 2])) == SAMPLE


def test_fields_with_defaults_may_be_missing() -> None:
    wire = wire_of(SAMPLE)
    del wire["items"], wire["maybe"], wire["table"]
    assert decode(Sample, msgpack.packb(wire)) == replace(SAMPLE, items=(), table=None)


def test_a_required_field_may_not_be_missing() -> None:
    wire = wire_of(SAMPLE)
    del wire["text"], wire["flag"]
    with pytest.raises(DecodeError, match=r"Sample: missing flag, text"):
        decode(Sample, msgpack.packb(wire))


@pytest.mark.parametrize(
    ("values", "says"),
    [
        ({"number": 1.0}, r"Sample.number: expected int, got 1.0"),
        ({"number": True}, r"Sample.number: expected int, got True"),
        ({"number": 2**63}, r"Sample.number: expected int, got 9223372036854775808"),
        ({"ratio": "1"}, r"Sample.ratio: expected float, got '1'"),
        ({"flag": 1}, r"Sample.flag: expected bool, got 1"),
        ({"text": b"x"}, r"Sample.text: expected str, got b'x'"),
        ({"blob": "x"}, r"Sample.blob: expected bytes, got 'x'"),
        ({"items": {"0": 1}}, r"Sample.items: expected a list, got dict of 1"),
        ({"items": [1, None]}, r"Sample.items\[1\]: expected int, got None"),
        ({"table": [1]}, r"Sample.table: expected a map with text keys, got \[1\]"),
        ({"table": {b"a": 1.0}}, r"Sample.table: expected a map with text keys, got dict of 1"),
        ({"table": {"a": "b"}}, r"Sample.table.a: expected float, got 'b'"),
        ({"text": "x" * (MAX_TEXT + 1)}, r"Sample: not msgpack"),
        ({"items": [0] * (MAX_LIST + 1)}, r"Sample: not msgpack"),
        ({"number": msgpack.Timestamp(1, 0)}, r"Sample: not msgpack"),
    ],
)
def test_wrong_fields_are_named(values: dict[str, Any], says: str) -> None:
    with pytest.raises(DecodeError, match=says):
        decode(Sample, changed(SAMPLE, **values))


@pytest.mark.parametrize(
    "data",
    [b"", b"\xc1", b"\x80", b"\x01", b"\xa1", encode(SAMPLE) + b"\x00", encode(SAMPLE)[:-1]],
)
def test_what_is_no_message_is_refused(data: bytes) -> None:
    with pytest.raises(DecodeError, match=r"^Sample: "):
        decode(Sample, data)


def test_size_is_checked_before_anything_else() -> None:
    data = encode(SAMPLE)
    with pytest.raises(DecodeError, match=rf"Sample: {len(data)} bytes, the limit is 8"):
        decode(Sample, data, max_bytes=8)


@pytest.mark.parametrize(
    ("values", "says"),
    [
        ({"number": 1.5}, "Sample.number: expected int, got float"),
        ({"number": 2**63}, "Sample.number: 9223372036854775808 needs more than 64 bits"),
        ({"ratio": "1.5"}, "Sample.ratio: expected float, got str"),
        ({"flag": "no"}, "Sample.flag: expected bool, got str"),
        ({"text": None}, "Sample.text: expected str, got NoneType"),
        ({"text": "ü" * MAX_TEXT}, "Sample.text: 65536 characters, the limit is 65536 bytes"),
        ({"blob": 5}, "Sample.blob: expected bytes, got int"),
        ({"items": (0,) * (MAX_LIST + 1)}, "Sample.items: 16385 items, the limit is 16384"),
        ({"table": {1: 1.0}}, "Sample.table: expected at most 1024 items with text keys"),
    ],
)
def test_a_writer_cannot_send_what_no_reader_takes(values: dict[str, Any], says: str) -> None:
    with pytest.raises(ValueError, match=says):
        encode(replace(SAMPLE, **values))


def test_numpy_scalars_are_numbers() -> None:
    sample = replace(SAMPLE, number=np.int32(3), ratio=np.float32(0.25), flag=np.bool_(False))
    assert decode(Sample, encode(sample)) == replace(SAMPLE, number=3, ratio=0.25, flag=False)


def test_a_nested_message_of_another_type_is_refused() -> None:
    frame = replace(EXAMPLES[0], rgb=POSE)
    with pytest.raises(ValueError, match=r"Frame.rgb: expected ImageData, got Pose"):
        encode(frame)
    with pytest.raises(TypeError, match="no wire form for"):
        encode(Unsupported([]))


@dataclass(frozen=True, slots=True)
class Unsupported:
    """A list has no wire form: messages are immutable."""

    items: list[int]


def test_a_class_without_wire_form_is_a_programming_error() -> None:
    with pytest.raises(TypeError, match="no wire form"):
        decode(Unsupported, b"\x80")


@pytest.mark.parametrize(
    ("array", "says"),
    [
        (np.zeros((2, 3), np.int32), r"f: expected <i4\[any, 2\], got shape \(2, 3\)"),
        (np.zeros(2, np.int32), r"f: expected <i4\[any, 2\], got shape \(2,\)"),
        (np.zeros((1, 2)), r"f: float64 does not become <i4"),
        (np.full((1, 2), 2**31), r"f: a value does not fit into <i4"),
        (np.full((1, 2), "a"), r"f: <U1 does not become <i4"),
    ],
)
def test_arrays_that_do_not_fit_are_not_sent(array: Array, says: str) -> None:
    with pytest.raises(ValueError, match=says):
        pack_array(array, SPEC, "f")


@pytest.mark.parametrize(
    "array",
    [
        np.array([[1, 2], [3, 4]], np.int64),
        np.array([[1, 2], [3, 4]], ">i4"),
        np.array([[1, 3], [2, 4]], np.int32).T,
        np.array([[1, 2], [3, 4]], np.uint8),
    ],
)
def test_arrays_are_narrowed_and_laid_out(array: Array) -> None:
    again = unpack_array(pack_array(array, SPEC, "f"), SPEC, "f")
    assert again.dtype == np.dtype("<i4")
    assert again.tolist() == [[1, 2], [3, 4]]
    assert not again.flags.writeable


def test_an_empty_array_has_no_dtype_to_lose() -> None:
    again = unpack_array(pack_array(np.zeros((0, 2)), SPEC, "f"), SPEC, "f")
    assert again.shape == (0, 2)


@pytest.mark.parametrize(
    ("values", "says"),
    [
        ({"dt": "<i8"}, "got dtype '<i8'"),
        ({"dt": "|O"}, r"got dtype '\|O'"),
        ({"dt": None}, "got dtype None"),
        ({"sh": [1, 3]}, r"got shape \[1, 3\]"),
        ({"sh": [-1, 2]}, "got shape list of 2"),
        ({"sh": [True, 2]}, "got shape list of 2"),
        ({"sh": [2**31, 2]}, "got shape list of 2"),
        ({"sh": [2**30, 2]}, "does not match 8 bytes"),
        ({"sh": None}, "got shape None"),
        ({"b": b"1234567"}, "does not match 7 bytes"),
        ({"b": "12345678"}, "in '12345678'"),
    ],
)
def test_arrays_that_lie_are_refused(values: dict[str, Any], says: str) -> None:
    wire = pack_array(np.zeros((1, 2), np.int32), SPEC, "f") | values
    with pytest.raises(DecodeError, match=says):
        unpack_array(wire, SPEC, "f")
    with pytest.raises(DecodeError, match="f: expected an array, got 5"):
        unpack_array(5, SPEC, "f")


def test_errors_stay_short_whatever_came() -> None:
    flood = "x" * 60_000
    for value in (flood, flood.encode(), [flood] * 9, {flood: 1}):
        assert len(brief(value)) < 60
        with pytest.raises(DecodeError) as caught:
            decode(Pose, changed(POSE, seq=value, T_world_camera=value))
        assert len(str(caught.value)) < 200


def test_the_bytes_of_a_field_are_not_copied_into_an_object_array() -> None:
    image = decode(ImageData, encode(ImageData("raw", "|u1", (1, 1), b"\x01")))
    assert image.shape == (1, 1)
    pose = decode(Pose, encode(POSE))
    assert pose.T_world_camera.dtype == np.float64
    assert np.array_equal(pose.T_world_camera, T_WORLD_CAMERA)


def test_arrays_of_a_class_are_described_in_errors() -> None:
    @dataclass(frozen=True, slots=True)
    class Holder:
        points_world: Annotated[Array, ArraySpec("<f4", (None, 3))]

    with pytest.raises(ValueError, match=r"Holder.points_world: expected <f4\[any, 3\]"):
        encode(Holder(np.zeros((3, 2), np.float32)))
