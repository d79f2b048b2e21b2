"""Recordings of ours: written, cut off, read again by us and by the readers of others."""

import json
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from sceneq_core.ingest.ingestor import Ingestor
from sceneq_core.ingest.keyframes import EveryNth, EveryNthParams
from sceneq_core.ingest.source import RawFrame, Skipped, Waiting
from sceneq_nodes._backends import build
from sceneq_nodes._images import frame_message
from sceneq_nodes._source_kinds import kind_of
from sceneq_nodes._wire import to_bytes
from sceneq_nodes.recording import forms
from sceneq_nodes.recording.mcap_writer import McapWriter
from sceneq_schemas.correction import PoseCorrection
from sceneq_schemas.topics import POSE_CORRECTION

from support.mcap_files import STEP_NS, frame, turned, write_mcap
from support.seven_scenes import depth_mm, write_folder


def source(path: Path, **params):
    return build("source", {"kind": "mcap", "path": str(path), **params})


def test_frames_come_back_bit_by_bit(tmp_path: Path) -> None:
    write_mcap(tmp_path / "run.mcap")
    assert kind_of(tmp_path / "run.mcap") == "mcap"
    played = source(tmp_path / "run.mcap")
    ingestor = Ingestor(played, EveryNth(EveryNthParams(every=1)))
    for number, raw in enumerate(played.frames()):
        came, went = ingestor.ingest(raw).keyframe, frame(number)
        assert (came.seq, came.stamp_ns) == (went.seq, went.stamp_ns)
        for name in ("rgb", "depth_m", "K", "T_world_camera"):
            one, other = getattr(came, name), getattr(went, name)
            assert one.dtype == other.dtype
            assert one.tobytes() == other.tobytes(), name
    assert number == 4


def test_jpeg_bytes_are_left_alone(tmp_path: Path) -> None:
    write_mcap(tmp_path / "run.mcap", 1, "jpeg")
    sent = frame_message(frame(0), "jpeg", "raw").rgb.data
    with (tmp_path / "run.mcap").open("rb") as file:
        channel_data = [m.data for _, c, m in make_reader(file).iter_messages([forms.COLOR_JPEG])]
    assert len(channel_data) == 1
    assert sent in channel_data[0]
    assert next(source(tmp_path / "run.mcap").frames()).read_rgb().shape == (48, 64, 3)


def test_other_programs_open_it(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    write_mcap(path)
    with path.open("rb") as file:
        reader = make_reader(file)
        assert reader.get_header().profile == "ros2"
        schemas = {s.name: s for s in reader.get_summary().schemas.values()}
        assert {s.encoding for s in schemas.values()} == {"ros2msg"}
        assert b"float64[16] t_world_camera" in schemas["sceneq_msgs/msg/Keyframe"].data
        counts = Counter(channel.topic for _, channel, _ in reader.iter_messages())
    assert counts == dict.fromkeys(
        (forms.COLOR, forms.DEPTH, forms.CAMERA, forms.KEYFRAME, forms.TF), 5
    )
    with AnyReader([path]) as bag:
        for connection, _, data in bag.messages([c for c in bag.connections if "tf" in c.topic]):
            (transform,) = bag.deserialize(data, connection.msgtype).transforms
            assert (transform.header.frame_id, transform.child_frame_id) == ("world", "camera")
    by_others = build("source", {"kind": "rosbag", "path": str(path)})
    last = list(by_others.frames())[-1]
    np.testing.assert_array_equal(last.read_depth_mm()[1:], depth_mm(4)[1:])
    np.testing.assert_allclose(last.T_world_camera, turned(0.4), atol=1e-12)


PANELS = {
    forms.COLOR: "sensor_msgs/msg/Image",
    forms.COLOR_JPEG: "sensor_msgs/msg/CompressedImage",
    forms.DEPTH: "sensor_msgs/msg/Image",
    forms.CAMERA: "sensor_msgs/msg/CameraInfo",
    forms.TF: "tf2_msgs/msg/TFMessage",
}
"""What Foxglove draws, by the names of types that it knows."""


@pytest.mark.parametrize("codec", ["raw", "jpeg"])
def test_it_has_what_a_viewer_needs_and_is_decoded_by_its_own_text(
    tmp_path: Path, codec: str
) -> None:
    path = tmp_path / "run.mcap"
    writer = write_mcap(path, 3, codec, close=False)
    writer.write(forms.packed_said(forms.MAP, "sceneq.map.v1", b"msgpack", 9_000_000_000))
    writer.write(forms.answer_said("{}", 9_000_000_001))
    writer.close()
    with path.open("rb") as file:
        reader = make_reader(file)
        summary = reader.get_summary()
        messages = list(reader.iter_messages())
        assert reader.get_header().profile == "ros2"
    told = summary.statistics
    assert (told.message_count, told.channel_count) == (3 * 5 + 2, 7)
    assert sum(told.channel_message_counts.values()) == len(messages) == told.message_count
    assert len(summary.chunk_indexes) == told.chunk_count == 4
    assert all(chunk.message_index_offsets for chunk in summary.chunk_indexes)
    assert {chunk.compression for chunk in summary.chunk_indexes} <= {"", "lz4", "zstd"}
    assert {schema.encoding for schema in summary.schemas.values()} == {"ros2msg"}
    assert {channel.message_encoding for channel in summary.channels.values()} == {"cdr"}
    types = {c.topic: summary.schemas[c.schema_id].name for c in summary.channels.values()}
    assert {topic: PANELS[topic] for topic in types if topic in PANELS}.items() <= types.items()
    assert len(set(types) & set(PANELS)) == 4
    knows_nothing = get_typestore(Stores.EMPTY)
    for schema in summary.schemas.values():
        new = get_types_from_msg(schema.data.decode(), schema.name)
        knows_nothing.register({k: v for k, v in new.items() if k not in knows_nothing.types})
    for schema, _, message in messages:
        decoded = knows_nothing.deserialize_cdr(message.data, schema.name)
        again = knows_nothing.serialize_cdr(decoded, schema.name)
        assert bytes(again) == bytes(message.data), schema.name


@pytest.mark.parametrize("lost", [1, 40, 700])
def test_what_a_killed_writer_left_is_read(tmp_path: Path, lost: int) -> None:
    path = tmp_path / "run.mcap"
    write_mcap(path, close=False)._file.close()
    path.write_bytes(path.read_bytes()[:-lost])
    frames = list(source(path).frames())
    assert len(frames) in (4, 5)
    assert [f.seq for f in frames] == [3 * n for n in range(len(frames))]


def test_seek_step_speed_and_loop(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    write_mcap(path)
    assert [f.seq for f in source(path, start_s=0.5).frames()] == [6, 9, 12]
    assert [f.seq for f in source(path, step=2).frames()] == [0, 6, 12]
    looped = source(path, loop=True).frames()
    seqs, stamps = zip(*[((f := next(looped)).seq, f.stamp_ns) for _ in range(12)], strict=True)
    assert (np.diff(seqs) == 3).all()
    assert (np.diff(stamps) == STEP_NS).all()
    slow = source(path, speed=1e-3).frames()
    assert isinstance(next(slow), RawFrame)
    assert isinstance(next(slow), Waiting)
    assert len(list(source(path, speed=1e6).frames())) >= 5


def test_a_correction_comes_with_the_keyframe_it_came_with(tmp_path: Path) -> None:
    correction = PoseCorrection(
        epoch=1, seq=1, full=True, frame_seq=3, stamp_ns=0,
        keyframe_seq=np.array([0]), T_world_camera=turned(0.7)[None],
    )  # fmt: skip
    writer = McapWriter(tmp_path / "run.mcap")
    data = to_bytes(POSE_CORRECTION, correction)
    writer.write(forms.packed_said(forms.CORRECTION, "sceneq.correction.v1", data, 0))
    for number in range(3):
        for said in forms.keyframe_said(frame_message(frame(number), "raw", "raw")):
            writer.write(said)
    writer.close()
    played = source(tmp_path / "run.mcap")
    ingestor = Ingestor(played, EveryNth(EveryNthParams(every=1)))
    corrected = [ingestor.ingest(raw).corrected for raw in played.frames()]
    assert [set(c) for c in corrected] == [set(), {0}, set()]
    np.testing.assert_array_equal(corrected[1][0], turned(0.7))


def test_an_incomplete_keyframe_is_skipped(tmp_path: Path) -> None:
    write_mcap(tmp_path / "run.mcap", 3, without_depth=1)
    good, bad, last = source(tmp_path / "run.mcap").frames()
    assert isinstance(good, RawFrame)
    assert isinstance(bad, Skipped)
    assert "no depth" in bad.reason
    assert last.seq == 6


def test_what_is_no_recording_of_ours_is_refused(tmp_path: Path) -> None:
    empty = McapWriter(tmp_path / "empty.mcap")
    empty.close()
    with pytest.raises(ValueError, match="no keyframe in it"):
        source(tmp_path / "empty.mcap")
    (tmp_path / "other.mcap").write_bytes(b"\x89MCAP0\r\n")
    with pytest.raises(ValueError, match="no recording of 'sceneq record'"):
        source(tmp_path / "other.mcap")
    with pytest.raises(ValueError, match="File exists"):
        McapWriter(tmp_path / "empty.mcap")


def test_imported_frames_are_those_of_the_source(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from sceneq_tools.import_command import run

    folder = write_folder(tmp_path / "wall", [0, 2, 5])
    (folder / "frame-000002.depth.png").write_bytes(b"gone")
    run(folder, tmp_path / "wall.mcap", quiet=True)
    assert "2 frames in" in (said := capsys.readouterr().out)
    assert "1 bad frames left out; the first: " in said
    run(tmp_path / "wall.mcap", tmp_path / "again", quiet=True)
    again = build("source", {"kind": kind_of(tmp_path / "again"), "path": str(tmp_path / "again")})
    before = build("source", {"kind": "folder", "path": str(folder), "step": 1})
    kept = [f for f in before.frames() if isinstance(f, RawFrame)]
    for one, other in zip(kept, again.frames(), strict=True):
        assert (one.seq, one.stamp_ns) == (other.seq, other.stamp_ns)
        np.testing.assert_array_equal(one.read_rgb(), other.read_rgb())
        np.testing.assert_array_equal(one.read_depth_mm(), other.read_depth_mm())
        np.testing.assert_array_equal(one.T_world_camera, other.T_world_camera)


def test_answers_are_plain_json(tmp_path: Path) -> None:
    writer = McapWriter(tmp_path / "run.mcap")
    writer.write(forms.answer_said('{"query_id": "q1"}', 5))
    writer.close()
    with AnyReader([tmp_path / "run.mcap"]) as bag:
        ((connection, at_ns, data),) = bag.messages()
        assert json.loads(bag.deserialize(data, connection.msgtype).data) == {"query_id": "q1"}
        assert (connection.topic, at_ns) == (forms.ANSWERS, 5)


def test_a_damaged_recording_loses_what_is_damaged_and_no_more(tmp_path: Path) -> None:
    write_mcap(tmp_path / "run.mcap")
    whole = (tmp_path / "run.mcap").read_bytes()
    lost = []
    for at in range(60, len(whole), len(whole) // 40):
        damaged = bytearray(whole)
        damaged[at] ^= 0xFF
        (tmp_path / "damaged.mcap").write_bytes(damaged)
        try:
            frames = list(source(tmp_path / "damaged.mcap").frames())
        except ValueError as error:
            assert "damaged.mcap" in str(error)  # noqa: PT017
            continue
        lost.append(5 - sum(isinstance(frame, RawFrame) for frame in frames))
    assert len(lost) > 30
    assert np.mean(lost) < 1.5
