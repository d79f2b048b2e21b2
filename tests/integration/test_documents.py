"""Every command of README.md and docs/ is typed as it stands (support/command_ways.py says how).

One running graph answers all pages. It is itself made of documented commands: a recording is
converted, a graph waits for frames, the recording is replayed into it.
"""

import json
import re
import shutil
import sys
import tempfile
import zlib
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from urllib.request import urlopen

import pytest

import sceneq_tools.suite
from sceneq_core.routing.answer import AMBIGUOUS, FOUND, NOT_FOUND
from sceneq_tools.synth import SynthParams

from support.command_ways import Row, Way, row_of
from support.documents import Block, Command, blocks, commands, pages
from support.kept_scene import KeptScene
from support.lidar_street import write_kitti
from support.live_graph import free_port
from support.more_data_sets import write_r3d
from support.reader import ONLY, Reader, Running, copy_examples, until
from support.tiny_suite import write_room, write_suite

pytestmark = [pytest.mark.integration, pytest.mark.timeout(300)]

FRAMES = 6
GRAPH = """\
watchdog: {silent_s: 60.0}
nodes:
  - id: ingest
    params:
      source: {kind: folder, path: .}
      rate_hz: 30
      keyframes: {kind: every, every: 1}
      wait_for: []
  - id: segmentation
    params: {segmenter: {kind: rgbd}}
  - id: mapping
  - id: views
  - id: encoding
    params: {encoder: {kind: hash}}
  - id: routing
    params: {encoder: {kind: hash}, labels: [ball, box, table, wall, floor]}
  - id: reasoning
"""
COMMANDS = [command for page in pages() for command in commands(page)]
LINKED = ("kitchen", "graph.yaml")
CAMERA = """\
from support.fake_cameras import Wall, realsense
globals().update(vars(realsense(Wall(100_000))))
"""


def of(way: Way) -> list[Command]:
    return [command for command in COMMANDS if row_of(command).way is way]


def the(story: str, pattern: str) -> Command:
    """Return the command of a story that matches; it may stand on several pages."""
    return of_story(story, pattern)[0]


def of_story(story: str, pattern: str = "") -> list[Command]:
    """Return the commands of a story that match."""
    return [c for c in of(Way.STORY) if row_of(c).detail == story and re.match(pattern, c.text)]


def where(command: Command) -> str:
    return command.where


def block_of(page: str, language: str) -> Block:
    """Return the first block of code of a language."""
    return next(block for block in blocks(page) if block.language == language)


@pytest.fixture(scope="module")
def reader(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Reader]:
    """A person in a folder with everything that the documents name."""
    folder = tmp_path_factory.mktemp("reader")
    write_room(SynthParams(frames=FRAMES), folder / "kitchen")
    stamps = "\n".join(f"{number / 10}" for number in range(FRAMES))
    (folder / "kitchen" / "stamps.txt").write_text(stamps)  # played in its own time, it is short
    write_r3d(folder / "room.r3d", 1, zlib.compress)
    (folder / "MAP").symlink_to(folder / "out")
    (folder / "graph.yaml").write_text(GRAPH)
    write_kitti(folder / "sequences" / "07", 3)
    copy_examples(folder)
    shutil.copy(folder / "kitchen" / "frame-000000.color.jpg", folder / "crop.png")
    (folder / "fakes").mkdir()
    (folder / "fakes" / "pyrealsense2.py").write_text(CAMERA)
    with tempfile.TemporaryDirectory(prefix="sq") as runtime:
        yield Reader(folder, Path(runtime))


@pytest.fixture(scope="module")
def graph(reader: Reader) -> Iterator[Running]:
    """The running graph beside which the pages are tried; it has seen the whole recording."""
    port, web = free_port(), free_port()
    reader.here |= dict.fromkeys(HERE, f"tcp/127.0.0.1:{port}")
    reader.here["localhost:8480"] = f"127.0.0.1:{web}"
    gateway = f"  - {{id: gateway, params: {{port: {web}}}}}\n"
    (reader.folder / "with-gateway.yaml").write_text(GRAPH + gateway)
    reader.succeeds(the("running_graph", "sceneq import").text)
    up = the("running_graph", "sceneq up").text
    with reader.starts(up, "with-gateway.yaml", "--port", str(port)) as running:
        running.wait_for("nodes are ready")
        reader.succeeds(the("running_graph", "sceneq replay run.mcap --rate 0").text)
        until(lambda: is_settled(reader))
        best = reader.learns("sceneq ask ball --json", r'"id": \d+').split()[1]
        reader.here |= {"teach 9 ": f"teach {best} ", "?id=9;": f"?id={best};"}
        yield running


def is_settled(reader: Reader) -> bool:
    """Whether all that was seen is described and can be asked about."""
    told = json.loads(reader.succeeds("sceneq status --json").printed)
    values = {node["node"]: node["values"] for node in told["nodes"]}
    is_described = values["encoding"].get("pending") == 0
    return is_described and values["routing"].get("answerable", 0) > 0


HERE = ("tcp/127.0.0.1:7447", "tcp/ROBOT:7447", "tcp/robot:7447")
"""Addresses of the router in the documents."""


@pytest.mark.parametrize("command", of(Way.BESIDE), ids=where)
def test_what_is_asked_of_a_running_graph(reader: Reader, graph: Running, command: Command) -> None:
    done = reader.succeeds(command.text)
    assert labels(command.shown) <= labels(done.printed), done.printed
    assert done.printed.strip()


def labels(printed: str) -> set[str]:
    """Return what lines of a printed answer begin with, and the heads of its tables.

    How a question ends is another matter on another map.
    """
    names = set(re.findall(r"^ *([a-z_]+): ", printed, re.M)) - {FOUND, AMBIGUOUS, NOT_FOUND}
    heads = re.findall(r"^ +((?:[A-Za-z]+(?: [a-z]+)*  +)+[A-Za-z]+(?: [a-z]+)*) *$", printed, re.M)
    return names | {name for head in heads for name in re.split("  +", head)}


def test_recordings_are_replayed_recorded_and_traced(reader: Reader, graph: Running) -> None:
    reader.succeeds(the("running_graph", "sceneq replay run.mcap  ").text)
    loop = the("running_graph", "sceneq replay run.mcap --rate 2").text
    with reader.starts(loop, *reader.beside(loop)) as playing:
        playing.wait_for("ready")
        trace = the("running_graph", "sceneq trace")
        assert labels(trace.shown) <= labels(reader.succeeds(trace.text).printed)
        for command in of_story("running_graph", "sceneq record"):
            recorder = reader.elsewhere("recorder", *LINKED)
            with recorder.starts(command.text, *reader.beside(command.text)) as recording:
                recording.wait_for("ready")
            assert (recorder.folder / "run.mcap").stat().st_size > 0
            recorder.clears("run.mcap")


def test_python_talks_to_the_running_graph(reader: Reader, graph: Running) -> None:
    code = block_of("docs/client.md", "python").text
    exec(reader.read(code).replace("the red mug on the table", "red ball"), {})


def test_numbers_are_watched(reader: Reader, graph: Running) -> None:
    watch = the("running_graph", "sceneq status --watch").text
    with reader.starts(watch, *reader.beside(watch)) as running:
        running.wait_for("mapping")
    port = str(free_port())
    serve = the("running_graph", "sceneq metrics").text.replace("9464", port)
    with reader.starts(serve, *reader.beside(serve)) as running:
        running.wait_for(f"http://127.0.0.1:{port}/metrics")
        until(lambda: b"sceneq_node_up{" in fetched(f"http://127.0.0.1:{port}/metrics"))


def fetched(address: str) -> bytes:
    with urlopen(address, timeout=20) as page:
        return page.read()


@pytest.mark.parametrize("command", of_story("running_graph", "sceneq viewer"), ids=where)
def test_a_viewer_is_opened(reader: Reader, graph: Running, command: Command) -> None:
    ports = ("--web-port", str(free_port()), "--grpc-port", str(free_port()))
    router = ("--router", reader.here["tcp/127.0.0.1:7447"])
    with reader.starts(command.text, *ports, *router) as viewer:
        viewer.wait_for(f"127.0.0.1:{ports[1]}")


def test_a_machine_is_looked_at(reader: Reader) -> None:
    """What is in the way here, such as a port, may be what the doctor finds."""
    done = reader.types(the("doctor", "sceneq doctor").text)
    assert done.code in (0, 1)
    assert "python" in done.printed.lower()


@pytest.mark.parametrize("command", of(Way.ALONE), ids=where)
def test_what_needs_no_graph(
    reader: Reader, kept: Path, monkeypatch: pytest.MonkeyPatch, command: Command
) -> None:
    monkeypatch.setattr(sceneq_tools.suite, "make_suite", two_small_rooms)
    monkeypatch.setitem(sys.modules, "liblzfse", SimpleNamespace(decompress=zlib.decompress))
    if command.text.startswith("sceneq import"):
        reader.clears("folder")
    there = reader.elsewhere("kept") if "--store" in command.text else reader
    done = there.has_done(command.text, *(["--dry-run"] if command.text.startswith("pip") else []))
    assert labels(command.shown) <= labels(done.printed), done.printed


def two_small_rooms(out: Path, *_: object) -> int:
    """Stand in for the eight rendered rooms of a suite, which test_synth.py renders."""
    write_suite(out)
    return 2


@pytest.fixture(scope="module")
def kept(reader: Reader) -> Path:
    """A kept scene, a suite, a map, a recording in MCAP, and masks of a network."""
    store = reader.elsewhere("kept").folder / "maps"
    scene = KeptScene(store / "room", reader.folder / "kitchen")
    scene.visit(reader.folder / "kitchen")
    scene.close()
    two_small_rooms(reader.folder / "suite")
    reader.has_done("sceneq map <folder> out/")
    if not (reader.folder / "run.mcap").exists():
        reader.succeeds(the("running_graph", "sceneq import").text)
    masks = block_of("docs/proposals.md", "python").text
    reader.runs_python(masks)
    return store


@pytest.mark.parametrize("command", of(Way.STAYS), ids=where)
def test_what_runs_until_it_is_ended(reader: Reader, kept: Path, command: Command) -> None:
    kind, pattern = ONLY[next(key for key in ONLY if key in command.text)]
    text = reader.read(command.text.partition("  #")[0].rstrip())
    if text in reader.started:
        return
    reader.started.add(text)
    there = reader.elsewhere("recorder", *LINKED) if "--record" in command.text else reader
    fakes = f"{reader.folder / 'fakes'}:{Path(__file__).parents[1]}"
    text = re.sub(r" --port \d+", "", command.text)
    more = ("--port", str(free_port()), "--only", kind)
    with there.starts(text, *more, PYTHONPATH=fakes) as running:
        running.wait_for(pattern)


def test_two_machines_as_the_page_has_them(reader: Reader) -> None:
    page = "docs/deployment.md"
    there = reader.elsewhere("machines")
    link, local = f"127.0.0.1:{free_port()}", f"127.0.0.1:{free_port()}"
    text = block_of(page, "yaml").text.replace("/data/kitchen", str(reader.folder / "kitchen"))
    for old, new in (
        ("server.local:7448", link),
        ("0.0.0.0:7448", link),
        ("127.0.0.1:7447", local),
    ):
        text = text.replace(old, new)
    (there.folder / "graph.yaml").write_text(text)
    for command in of_story("machines"):
        if " up " not in command.text:
            there.succeeds(command.text)
            continue
        only = "ingest" if "robot" in command.text else "copy"
        port = [] if only == "copy" else ["--port", str(free_port())]
        with there.starts(command.text, *port, "--only", only) as running:
            running.wait_for("is ready")


def test_a_robot_is_played(reader: Reader) -> None:
    robot = reader.elsewhere("robot", "docs", *LINKED)
    port = free_port()
    robot.here = dict.fromkeys(HERE, f"tcp/127.0.0.1:{port}")
    up = the("robot", "sceneq up").text
    with robot.starts(up, "--port", str(port), "--only", "ingest") as running:
        running.wait_for("ingest is ready")
        played = robot.succeeds(the("robot", "python").text)
        assert f"played {FRAMES} frames" in played.printed
        assert robot.learns("sceneq status --json", r'"frames": [1-9]')


def test_a_secured_graph_lets_in_who_has_a_certificate(reader: Reader) -> None:
    site = reader.elsewhere("secured", *LINKED)
    port = free_port()
    site.here = {"tls/127.0.0.1:7447": f"tls/127.0.0.1:{port}"}
    robot = GRAPH.replace("folder, path: .", "ros2, colour_topic: /colour, depth_topic: /depth")
    (site.folder / "robot.yaml").write_text(robot)
    for command in of_story("secured", "sceneq secure"):
        site.succeeds(command.text)
    nodes = ("--only", "ingest,segmentation,mapping,views,encoding,routing")
    with site.starts(the("secured", "sceneq up").text, "--port", str(port), *nodes) as running:
        running.wait_for("nodes are ready")
        running.wait_for("ingest +finished")
        assert site.learns(the("secured", "SCENEQ_CREDENTIALS").text, "confidence: ")
        assert site.learns(the("secured", "zenoh").text, '"instances"')


def test_a_simulated_robot_is_started(reader: Reader) -> None:
    """What it sees, and what is moved before it, is in test_live_sim.py: rendering takes long."""
    live = reader.elsewhere("live", "graph.yaml")
    shapes = {"SCENEQ_FURNITURE_DIR": str(live.folder)}  # none there: simple ones
    with live.starts(the("live_demo", "sceneq demo").text, **shapes) as running:
        running.wait_for("a simulated robot in living room 0")
        Running(running.process, live.folder / "out/demo/graph.log").wait_for("ingest +started")


def test_every_story_is_told() -> None:
    told = {"running_graph", "machines", "robot", "secured", "live_demo", "doctor"}
    assert {row_of(command).detail for command in of(Way.STORY)} == told
    assert all(isinstance(row_of(command), Row) for command in COMMANDS)


def test_make_knows_what_it_is_told(reader: Reader) -> None:
    for text in sorted({c.text.partition("  ")[0] for c in of(Way.MAKE)}):
        assert reader.makes(text).code == 0
