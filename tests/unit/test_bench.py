"""What benches measure and how it is told; how fast anything is, is not asked here."""

import json
import os
import sys
from collections.abc import Callable
from dataclasses import asdict, replace
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from sceneq_core.encoding.encoder import Crop
from sceneq_core.ingest.source import Camera
from sceneq_nodes._bus import Received
from sceneq_schemas.frame import Frame
from sceneq_schemas.mask import Masks
from sceneq_schemas.topics import FEATURE_DELTA, MAP_DELTA, VIEW_DELTA, Topic
from sceneq_tools import bench_command, cli
from sceneq_tools.bench import laps, query_feeder, registry, render, report, scale, stages
from sceneq_tools.bench.codec import CODECS, codec, synthetic_frame
from sceneq_tools.bench.measurement import (
    Measurement,
    Options,
    in_turns_ms,
    latency,
    median,
    p99,
    samples_ms,
)
from sceneq_tools.bench.query_feeder import options_from, text_from
from sceneq_tools.bench.recording import first_frames
from sceneq_tools.bench.reference import fixed_work, fixed_work_ms
from sceneq_tools.bench.stopwatch import Stopwatch
from sceneq_tools.bench.stream import rate_hz
from sceneq_tools.errors import UserError

from support.fake_bus import FakeBus
from support.messages import EXAMPLES
from support.recording import write_recording

BRIEF = Options(seconds=0.001, quiet=True)
Outcome = tuple[int, str, str]


def test_a_measurement_stands_beside_its_reference() -> None:
    assert Measurement("a", 3.0, "ms", "copy", 2.0).ratio == 1.5
    assert Measurement("a", 3.0, "ms").ratio is None
    ups = [
        unit
        for unit in ("ms", "MB", "frames/s", "MB/s")
        if Measurement("a", 1, unit).more_is_better
    ]
    assert ups == ["frames/s", "MB/s"]


@pytest.mark.parametrize(("name", "value"), [("seconds", 0.0), ("frames", 0)])
def test_options_that_make_no_sense_are_named(name: str, value: float) -> None:
    with pytest.raises(ValueError, match=name):
        Options(**{name: value})


def test_options_travel_to_another_process() -> None:
    options = Options(Path("/rooms/a b"), Path("graph.yaml"), 0.5, 7, True)
    assert options_from(text_from(options)) == options
    assert options_from(text_from(Options())) == Options()


def test_samples_are_taken_until_time_and_number_suffice() -> None:
    calls = []
    taken = samples_ms(lambda: calls.append(1), seconds=1e-9, warm_ups=2, least=3)
    assert len(taken) == 3
    assert len(calls) == 5
    assert all(one >= 0 for one in taken)


def test_what_is_measured_may_be_processor_time() -> None:
    ticks = iter([0.0, 2.0, 10.0, 13.0, 20.0, 24.0])
    taken = samples_ms(lambda: None, seconds=1e-9, least=2, clock=lambda: next(ticks))
    assert taken == [2000.0, 3000.0]
    stopwatch = Stopwatch(clock=lambda: next(ticks))
    with stopwatch.watching({"scaling": "sceneq_tools.bench.scale:digest"}):
        assert scale.digest(np.array([1, 2], np.uint8)) == 258
    assert stopwatch.taken_ms == {"scaling": [4000.0]}


def test_works_are_measured_in_turns() -> None:
    calls: list[str] = []
    works = [lambda: calls.append("a"), lambda: calls.append("b")]
    first, second = in_turns_ms(works, seconds=1e-9, warm_ups=1, least=3)
    assert (len(first), len(second)) == (3, 3)
    assert calls == ["a", "b", *["a", "b"] * 3]


def test_latency_is_median_and_tail() -> None:
    taken = [1.0] * 98 + [2.0, 100.0]
    assert median(taken) == 1.0
    assert p99(taken) == pytest.approx(2.98)
    both = latency("get", taken, "tcp", [0.5] * 10)
    assert [(one.name, one.unit, one.reference) for one in both] == [
        ("get p50", "ms", 0.5),
        ("get p99", "ms", 0.5),
    ]


def test_the_reference_work_is_always_the_same() -> None:
    assert fixed_work() == fixed_work()
    assert fixed_work_ms(0.001) > 0


def test_every_codec_is_measured() -> None:
    measured = list(codec(BRIEF))
    names = {f"{name}, {what}" for name in CODECS for what in ("size", "encode", "decode")}
    assert {one.name for one in measured} == names
    assert all(one.value > 0 and one.ratio for one in measured)
    sizes_mb = [one.value for one in measured if one.unit == "MB"]
    assert sizes_mb[0] > 1.5  # raw pixels
    assert max(sizes_mb[1:]) < 1.0


def test_the_frame_that_is_coded_looks_like_one() -> None:
    frame = synthetic_frame()
    assert frame.rgb.shape == (480, 640, 3)
    assert 0.08 < (frame.depth_m == 0).mean() < 0.12
    assert 1.0 < np.median(frame.depth_m) < 5.0
    assert (synthetic_frame().depth_m == frame.depth_m).all()


def test_a_stopwatch_times_what_it_watches_and_leaves_no_trace() -> None:
    owner = import_module("sceneq_tools.bench.reference")
    plain = owner.fixed_work
    stopwatch = Stopwatch()
    with stopwatch.watching({"work": "sceneq_tools.bench.reference:fixed_work"}):
        results = [owner.fixed_work(), owner.fixed_work()]
    assert owner.fixed_work is plain
    assert results == [fixed_work()] * 2
    assert len(stopwatch.taken_ms["work"]) == 2


def test_a_stopwatch_lets_exceptions_pass_and_names_what_is_not_there() -> None:
    stopwatch = Stopwatch()
    with (
        stopwatch.watching({"read": "sceneq_tools.bench.report:read_baseline"}),
        pytest.raises(UserError),
    ):
        report.read_baseline(Path("/no/such/file"))
    assert len(stopwatch.taken_ms["read"]) == 1
    with pytest.raises(AttributeError, match="no_such"):
        stopwatch._watch("x", "sceneq_tools.bench.report:no_such")


def test_everything_that_is_watched_exists() -> None:
    for target in {**stages.NODES, **stages.PARTS, **stages.KEYFRAMES}.values():
        module, _, path = target.partition(":")
        owner = import_module(module)
        for name in path.split("."):
            owner = getattr(owner, name)
        assert callable(owner)


def test_growth_compares_the_last_third_with_the_first() -> None:
    assert list(stages.growth([1.0, 2.0])) == []
    (growth,) = stages.growth([1.0, 1.0, 9.0, 9.0, 3.0, 3.0])
    assert growth.ratio == 3.0


def test_a_pipeline_is_as_quick_as_its_slowest_stage_and_its_cores_allow() -> None:
    assert stages.pipelined([10.0, 50.0, 20.0]) == pytest.approx(20.0)
    assert stages.pipelined([60.0, 60.0, 80.0]) == pytest.approx(10.0)


def test_the_first_keyframe_starts_the_clock() -> None:
    assert rate_hz(21, 2.0) == 10.0
    with pytest.raises(UserError, match="at least two keyframes"):
        rate_hz(1, 2.0)


def test_processes_are_given_the_first_frames_only(tmp_path: Path) -> None:
    room = write_recording(tmp_path / "room", frames=4)
    with first_frames(Options(room)) as options:
        assert options.source == room
    with first_frames(Options(room, frames=2)) as options:
        assert options.source is not None
        assert options.source.name == "room"
        names = {path.name for path in options.source.iterdir()}
        assert {name[:12] for name in names if name.startswith("frame")} == {
            "frame-000000",
            "frame-000001",
        }
        assert "camera-intrinsics.txt" in names
    with (
        pytest.raises(UserError, match=r"--frames: .*no frames"),
        first_frames(Options(tmp_path, frames=2)),
    ):
        pass


def test_laps_go_on_in_time_and_number() -> None:
    frame, masks = (next(m for m in EXAMPLES if type(m) is kind) for kind in (Frame, Masks))
    kept = laps.Kept()
    for seq, stamp_ns in ((3, 100), (5, 300)):
        kept.frames[seq] = replace(frame, seq=seq, stamp_ns=stamp_ns)
        kept.masks[seq] = replace(masks, seq=seq, stamp_ns=stamp_ns)
    played = list(laps.on_and_on(kept, 5))
    assert [one.seq for one, _ in played] == [3, 5, 6, 8, 9]
    assert [one.stamp_ns for _, one in played] == [100, 300, 500, 700, 900]


def test_every_bench_can_be_loaded() -> None:
    assert all(callable(registry.load(name)) for name in registry.BENCHES)
    assert set(registry.BENCHES) >= registry.NEED_SOURCE | registry.ON_REQUEST


def test_frames_a_second_are_over_all_frames() -> None:
    ms, per_s = render.frames("frame", [100.0, 100.0, 400.0], 5.0, 10.0)
    assert (ms.value, ms.ratio) == (100.0, 10.0)
    assert (per_s.value, per_s.reference) == (5.0, 100.0)


def test_every_pose_is_rendered_once_after_a_warm_up() -> None:
    seen: list[int] = []
    poses = [np.full((4, 4), i) for i in range(3)]
    taken_ms, busy_ms = render.looks(lambda pose: seen.append(int(pose[0, 0])), poses, quiet=True)
    assert len(taken_ms) == len(busy_ms) == 3
    assert seen == [0, 0, 1, 2]


def test_work_on_few_cores_ends_on_all() -> None:
    usable = os.sched_getaffinity(0)
    with render.on_cores(1):
        assert len(os.sched_getaffinity(0)) == 1
    assert os.sched_getaffinity(0) == usable


def test_the_cube_fills_the_middle_of_the_picture() -> None:
    camera = Camera(np.array([[32.0, 0, 31.5], [0, 32.0, 23.5], [0, 0, 1]]), (64, 48))
    distance_m = render.cube_cast(camera)()["t_hit"].numpy()
    hit = np.isfinite(distance_m)
    assert hit[24, 32]
    assert not hit[0, 0]
    assert 0.1 < hit.mean() < 0.5


RESULTS = {
    "bus": [Measurement("get p50", 0.5, "ms", "tcp", 0.1), Measurement("lost", 0.0, "frames")],
    "render": [Measurement("frame", 6.0, "frames/s", "cube", 60.0)],
}


def test_rows_show_value_reference_and_ratio() -> None:
    assert list(report.rows(RESULTS)) == [
        ("bus", "get p50", "0.5 ms", "tcp: 0.1", "5x"),
        ("bus", "lost", "0 frames", "", ""),
        ("render", "frame", "6 frames/s", "cube: 60", "0.1x"),
    ]
    assert report.figures(1234.5) == "1234"


def test_a_baseline_is_compared_by_ratios(tmp_path: Path) -> None:
    path = tmp_path / "then.json"
    path.write_text(json.dumps(report.as_json(RESULTS)))
    then = report.read_baseline(path)
    told = [row[-1] for row in report.rows(RESULTS, then)]
    assert told == ["1.00x better", "same", "1.00x better"]
    # Twice as slow on a machine that is twice as slow: no change.
    assert report.compared("bus", Measurement("get p50", 1.0, "ms", "tcp", 0.2), then) == (
        "1.00x better"
    )
    slower = Measurement("get p50", 1.0, "ms", "tcp", 0.1)
    assert report.compared("bus", slower, then) == "2.00x worse"
    faster = Measurement("frame", 12.0, "frames/s", "cube", 60.0)
    assert report.compared("render", faster, then) == "2.00x better"
    assert report.compared("bus", Measurement("lost", 3.0, "frames"), then) == "was 0"
    assert report.compared("bus", Measurement("other", 3.0, "ms"), then) == "new"


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"schema": "other", "measurements": []}'])
def test_a_file_that_is_no_baseline_is_named(tmp_path: Path, text: str) -> None:
    path = tmp_path / "then.json"
    path.write_text(text)
    with pytest.raises(UserError, match=r"then\.json"):
        report.read_baseline(path)


def test_json_tells_the_machine() -> None:
    document = report.as_json(RESULTS)
    assert document["schema"] == "sceneq.bench.v1"
    assert document["machine"]["cores"] >= 1
    assert set(document["machine"]) == {"cores", "processor", "system", "python"}
    assert document["measurements"][0] == {
        "bench": "bus",
        "name": "get p50",
        "value": 0.5,
        "unit": "ms",
        "beside": "tcp",
        "reference": 0.1,
        "ratio": 5.0,
    }


@pytest.fixture
def run(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[..., Outcome]:
    def run_bench(*arguments: str) -> Outcome:
        monkeypatch.setattr(sys, "argv", ["sceneq", "bench", *arguments])
        with pytest.raises(SystemExit) as ended:
            cli.main()
        return int(ended.value.code or 0), *capsys.readouterr()

    return run_bench


def test_the_command_prints_writes_and_compares(
    run: Callable[..., Outcome], tmp_path: Path
) -> None:
    path = str(tmp_path / "codec.json")
    code, out, err = run("codec", "--seconds", "0.01", "--json", path)
    assert (code, err) == (0, "bench: 1 stages\n" + err.splitlines(True)[-1])
    assert "jpeg + zstd, encode" in out
    assert len(json.loads(Path(path).read_text())["measurements"]) == 15
    code, out, err = run("codec", "--seconds", "0.01", "--baseline", path, "--quiet")
    assert (code, err) == (0, "")
    assert "against baseline" in out
    assert "better" in out


def test_wrong_stages_and_missing_recordings_are_one_line(
    run: Callable[..., Outcome], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bench_command, "sample", lambda: None)
    code, out, err = run("coffee")
    assert (code, out) == (2, "")
    assert err.startswith("sceneq: no stage named 'coffee'")
    code, out, err = run("stages", "--quiet", "--seconds", "0.01")
    assert (code, out) == (2, "")
    assert err == "sceneq: a folder of frames is needed: --source FOLDER\n"
    assert bench_command._chosen([], None) == ["codec", "bus", "render", "scale"]
    usual = [name for name in registry.BENCHES if name not in registry.ON_REQUEST]
    assert bench_command._chosen([], Path("room")) == usual


def test_a_question_to_many_instances_stands_beside_the_product(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(scale, "INSTANCES", 300)
    monkeypatch.setattr(scale, "LEAST", 2)
    measured = {one.name: one for one in scale.scale(BRIEF)}
    assert list(measured)[:2] == ["'mug' of 300 x 512, p50", "'mug' of 300 x 512, p99"]
    assert list(measured)[-1] == "30 of 300 x 512 changed, p99"
    assert len(measured) == 8
    assert all(one.ratio and one.beside == "matrix times vector" for one in measured.values())


def test_the_random_encoder_keeps_to_what_it_said() -> None:
    encoder = scale.RandomEncoder()
    first, second, again = encoder.encode_texts(["red mug", "mug", "red mug"])
    assert np.array_equal(first, again)
    assert abs(float(first @ second)) < 0.3
    assert encoder.encode_texts([]).shape == (0, scale.DIM)
    black = Crop(np.zeros((4, 5, 3), np.uint8), np.ones((4, 5), np.bool_))
    descriptors, features = encoder.encode_crops([black, black])
    assert np.array_equal(descriptors, features)
    assert np.linalg.norm(descriptors, axis=1) == pytest.approx([1.0, 1.0])


def heard(topic: Topic, seq: int, **ids: str) -> Received:
    message = replace(next(one for one in EXAMPLES if type(one) is topic.message), seq=seq)
    return Received(topic, topic.key(scene="room", **ids), {"scene": "room", **ids}, message)


def test_the_last_changes_are_told_again_as_the_next_ones() -> None:
    bus, changes = FakeBus(), query_feeder.LastChanges()
    for seq in (7, 8):
        changes.step(heard(MAP_DELTA, seq))
        changes.step(heard(VIEW_DELTA, seq + 10))
        changes.step(heard(FEATURE_DELTA, seq + 20, model="m"))
    feeder = query_feeder.Feeder(bus, changes)
    feeder.tell_keyframe()
    feeder.tell_keyframe()
    assert [one.seq for one in bus.sent(MAP_DELTA)] == [9, 10]
    assert [one.seq for one in bus.sent(VIEW_DELTA)] == [19, 20]
    assert [one.seq for one in bus.sent(FEATURE_DELTA)] == [29, 30, 31, 32]
    assert not any(one.full for one in bus.sent(MAP_DELTA))


def test_what_was_fed_travels_as_text() -> None:
    fed = query_feeder.Fed("room", {"encoder": {"kind": "hash"}}, 12)
    assert query_feeder.Fed(**json.loads(json.dumps(asdict(fed)))) == fed
