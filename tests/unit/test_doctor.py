"""The checks of ``sceneq doctor`` on machines that are healthy, ill and odd."""

import base64
import json
import os
import re
import socket
import subprocess
import sys
import threading
from collections.abc import Callable
from hashlib import sha256
from importlib.metadata import PackageNotFoundError
from pathlib import Path
from types import SimpleNamespace

import pytest

from sceneq_nodes import _assets
from sceneq_tools import cli
from sceneq_tools.doctor import examination, folders, libraries, machine, network, packages
from sceneq_tools.doctor.finding import Finding, State, ok, problem, warning
from sceneq_tools.doctor_command import verdict
from sceneq_tools.errors import UserError
from sceneq_tools.room.models import libraries as room_libraries

ROOT = Path(__file__).parents[2]
MIB, GIB = 1024**2, 1024**3


def versions(**installed: str) -> Callable[[str], str]:
    def version(name: str) -> str:
        try:
            return installed[name.replace("-", "_")]
        except KeyError:
            raise PackageNotFoundError(name) from None

    return version


def test_python_is_compared_with_what_the_package_asks_for() -> None:
    assert packages.python_version((3, 11, 4)).state == "ok"
    old = packages.python_version((3, 9, 2), ">=3.11")
    assert (old.state, old.found) == ("problem", "3.9.2, needs >=3.11")


def test_packages_are_compared_with_their_ranges() -> None:
    wanted = ["numpy>=2.0", "rich<15,>=13.9", "pytest>=8; extra == 'dev'", "typer"]
    fine = packages.package_versions(wanted, versions(numpy="2.1", rich="14.0", typer="0.1"))
    assert (fine.state, fine.found) == ("ok", "3 packages in the versions asked for")
    ill = packages.package_versions(wanted, versions(numpy="1.26", typer="0.1"))
    assert ill.state == "problem"
    assert ill.found == "numpy 1.26 (needs >=2.0), rich is missing (needs <15,>=13.9)"
    assert ill.mend == f"{sys.executable} -m pip install 'numpy>=2.0' 'rich<15,>=13.9'"


def test_the_installed_packages_suit(tmp_path: Path) -> None:
    assert packages.package_versions().state == "ok"


@pytest.mark.parametrize(
    ("installed", "gpu", "said"),
    [
        ({"torch": "2.13.0+cpu"}, False, "2.13.0+cpu: a CPU build"),
        ({"torch": "2.13.0+cpu"}, True, "the GPU here stays idle"),
        ({"torch": "2.13.0"}, False, "no GPU driver here"),
        ({"torch": "2.13.0"}, True, "a GPU driver is loaded"),
        ({}, False, "not installed"),
    ],
)
def test_torch_says_what_it_was_built_for(
    tmp_path: Path, installed: dict[str, str], gpu: bool, said: str
) -> None:
    driver = tmp_path / "version"
    if gpu:
        driver.touch()
    found = packages.torch_build(versions(**installed), driver)
    assert said in found.found
    assert found.is_problem is (not installed)


def test_rerun_needs_its_program(tmp_path: Path) -> None:
    there = versions(rerun_sdk="0.41.0")
    spec = SimpleNamespace(submodule_search_locations=[str(tmp_path)])
    assert packages.rerun_viewer(versions(), lambda name: None).state == "warning"
    assert "without its viewer" in packages.rerun_viewer(there, lambda name: spec).found
    (tmp_path / "rerun").touch(mode=0o755)
    assert packages.rerun_viewer(there, lambda name: spec) == ok("0.41.0 with its viewer")


def test_weights_are_compared_with_the_sums_of_their_package(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    info = tmp_path / "toy_weights-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: toy-weights\nVersion: 1.0\n")
    data = {"model.bin": b"weights", "gone.bin": b"more"}
    digests = {n: base64.urlsafe_b64encode(sha256(d).digest()) for n, d in data.items()}
    lines = [f"{n},sha256={d.decode().rstrip('=')},7" for n, d in digests.items()]
    (info / "RECORD").write_text("\n".join([*lines, "unsigned.txt,,"]) + "\n")
    for name, content in data.items():
        (tmp_path / name).write_bytes(content)
    monkeypatch.syspath_prepend(str(tmp_path))
    fine = packages.weights(["toy-weights"])
    assert fine == ok("1 packages with weights, unchanged")
    (tmp_path / "model.bin").write_bytes(b"cut")
    (tmp_path / "gone.bin").unlink()
    ill = packages.weights(["toy-weights"])
    assert (ill.state, ill.found) == ("problem", "damaged: model.bin, gone.bin")
    assert "toy-weights --force-reinstall" in ill.mend


def test_a_library_that_does_not_load_is_named_with_its_package() -> None:
    def load(name: str) -> None:
        if name.startswith("libusb"):
            raise OSError(f"{name}: cannot open shared object file")

    found = libraries.system_libraries(load=load)
    assert found.found == "cannot load libusb-1.0.so.0"
    assert found.mend.endswith("apt-get install libusb-1.0-0")
    assert libraries.system_libraries(load=lambda name: None).state == "ok"


def test_set_up_and_doctor_know_the_same_libraries() -> None:
    script = (ROOT / "deploy" / "system-libraries").read_text()
    assert dict(re.findall(r"^need (\S+) (\S+)$", script, re.MULTILINE)) == libraries.LIBRARIES
    assert machine.FURNITURE_PACKAGE in script
    assert str(machine.FURNITURE) in script
    assert machine.FURNITURE == room_libraries.DEFAULT_FOLDER
    assert machine.FURNITURE_VARIABLE == room_libraries.FOLDER_VARIABLE
    assert machine.FURNITURE_PACKAGE in room_libraries.PACKAGE_HINT


def test_cores_and_memory(tmp_path: Path) -> None:
    assert machine.cores(8) == ok("8")
    assert machine.cores(1).state == "warning"
    meminfo, limit = tmp_path / "meminfo", tmp_path / "memory.max"
    meminfo.write_text(f"MemTotal: 9 kB\nMemAvailable: {8 * GIB // 1024} kB\n")
    assert machine.memory(meminfo, limit) == ok("8.0 GiB available")
    limit.write_text(f"{2 * GIB}\n")
    assert machine.memory(meminfo, limit).state == "warning"
    limit.write_text("max\n")
    assert machine.memory(meminfo, limit).state == "ok"


@pytest.mark.parametrize(
    ("now_s", "resolution_s", "synced", "state", "said"),
    [
        (1.8e9, 1e-9, True, "ok", "2027-01-15 08:00 UTC, synchronised"),
        (1.8e9, 1e-9, None, "ok", "2027-01-15 08:00 UTC"),
        (1.8e9, 1e-9, False, "warning", "not synchronised"),
        (0.0, 1e-9, True, "warning", "1970-01-01 00:00 UTC cannot be"),
        (1.8e9, 0.016, True, "warning", "resolution 0.016 s"),
    ],
)
def test_clock(
    now_s: float, resolution_s: float, synced: bool | None, state: str, said: str
) -> None:
    found = machine.clock(lambda: now_s, resolution_s, lambda: synced)
    assert found.state == state
    assert said in found.found


@pytest.mark.parametrize(("printed", "synced"), [("yes", True), ("no", False), ("", None)])
def test_timedatectl_may_not_know(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, printed: str, synced: bool | None
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    assert machine.ntp_synchronised() is None
    program = tmp_path / "timedatectl"
    program.write_text(f"#!/bin/sh\necho {printed}\n")
    program.chmod(0o755)
    assert machine.ntp_synchronised() is synced


def test_furniture_is_optional_and_says_what_for(tmp_path: Path) -> None:
    without = machine.furniture(tmp_path / "none")
    assert without.state == "ok"
    assert "realistic" in without.found
    assert without.mend.endswith("apt-get install sweethome3d-furniture")
    (tmp_path / "Scopia.sh3f").touch()
    assert machine.furniture(tmp_path) == ok(f"1 libraries of models in {tmp_path}")


@pytest.mark.parametrize(
    ("free", "state"), [(9_000_000_000, "ok"), (10**9, "warning"), (10**8, "problem")]
)
def test_disk_is_judged_by_the_fullest(tmp_path: Path, free: int, state: str) -> None:
    full = tmp_path / "full"
    full.mkdir()
    wanted = [tmp_path / "a" / "b", full / "not" / "yet"]
    found = folders.disk(wanted, lambda folder: free if folder == full else 10**12)
    assert found.state == state
    assert str(full) in found.found


def test_a_place_that_refuses_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fine = folders.writable([tmp_path / "out"])
    assert fine == ok(str(tmp_path / "out"))

    def refuse(dir: Path) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(folders.tempfile, "TemporaryFile", refuse)
    found = folders.writable([tmp_path / "out"])
    assert found.found == f"{tmp_path}: permission denied"
    assert found.mend == f"sudo chown -R {os.geteuid()} {tmp_path}"


def test_shared_memory_of_a_container_is_small(tmp_path: Path) -> None:
    small = folders.shared_memory(tmp_path, lambda _: (64 * MIB, 60 * MIB), container=True)
    assert small.state == "warning"
    assert small.found.startswith(f"60 of 64 MiB free in {tmp_path}")
    assert small.mend.startswith("docker run --shm-size")
    full = folders.shared_memory(tmp_path, lambda _: (8 * GIB, MIB), container=False)
    assert full.mend.endswith(f"mount -o remount,size=1G {tmp_path}")
    assert folders.shared_memory(tmp_path, lambda _: (8 * GIB, 4 * GIB)).state == "ok"
    assert folders.shared_memory(tmp_path / "none").state == "warning"


def test_what_killed_processes_left_in_shared_memory_is_found(tmp_path: Path) -> None:
    left, used = tmp_path / "1.zenoh", tmp_path / "2.zenoh"
    for path in (left, used, tmp_path / "other"):
        path.write_bytes(bytes(MIB))
    found = folders.leftovers(tmp_path, lambda: {str(used)})
    assert found.found.startswith("1 files of killed processes hold 1 MiB")
    assert found.mend == f"rm {left}"
    assert folders.leftovers(tmp_path, lambda: {str(left), str(used)}) == ok("none")


def test_files_that_a_process_has_mapped_are_in_use(tmp_path: Path) -> None:
    process = tmp_path / "12"
    process.mkdir()
    (process / "maps").write_text(
        "7f00-7f01 r--p 0 00:00 1    /lib/libc.so\n7f02-7f03 rw-s 0 0:1 2    /dev/shm/5.zenoh\n"
    )
    (tmp_path / "13").mkdir()
    assert folders.mapped_files(tmp_path) == {"/dev/shm/5.zenoh"}


def test_the_encoder_files_are_compared_with_their_sums(tmp_path: Path) -> None:
    assert "not prepared" in folders.encoder_finding(tmp_path / "none", _assets.damaged).found
    assert folders.encoder_finding(tmp_path, _assets.damaged).found.endswith("sha256.json")
    for name in _assets.MADE:
        (tmp_path / name).write_bytes(name.encode())
    sums = {name: _assets._sum(tmp_path / name) for name in _assets.MADE}
    (tmp_path / _assets.SUMS).write_text(json.dumps(sums))
    assert folders.encoder_finding(tmp_path, _assets.damaged).state == "ok"
    (tmp_path / _assets.MADE[0]).write_bytes(b"cut")
    cut = folders.encoder_finding(tmp_path, _assets.damaged)
    assert cut.found == f"damaged in {tmp_path}: classifier.onnx"
    assert cut.mend.startswith(f"rm -r {tmp_path} && ")


def test_who_holds_a_port_is_named() -> None:
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        port = listener.getsockname()[1]
        assert network.port_holder(port) is None
        listener.listen()
        holder = network.port_holder(port)
    assert holder is not None
    assert holder.endswith(f"(pid {os.getpid()})")
    assert network.port_holder(port) is None


def test_a_port_held_by_others_is_a_problem_and_by_a_graph_is_not() -> None:
    holders = {7447: "zenohd (pid 5)", 7500: "python -m sceneq_nodes router (pid 6)"}
    assert network.ports([7448], holders.get) == ok("7448 free")
    assert network.ports([7500], holders.get) == ok("7500: a graph is running")
    foreign = network.ports([7447, 7500], holders.get)
    assert foreign.found == "7447 is held by zenohd (pid 5)"
    assert re.fullmatch(r"sceneq up --port \d+", foreign.mend)
    far = f"/home/sceneq/{'deep/' * 20}python -m http.server (pid 77)"
    shown = network.ports([80], {80: far}.get).found
    assert shown.startswith("80 is held by /home/sceneq/deep")
    assert shown.endswith("http.server (pid 77)")
    assert len(shown) < 90


def test_the_ports_are_those_of_the_graph_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert network.graph_ports() == [7447]
    monkeypatch.chdir(tmp_path)
    text = (ROOT / "graph.yaml").read_text()
    (tmp_path / "graph.yaml").write_text(text.replace("127.0.0.1:7447", "127.0.0.1:7999"))
    assert network.graph_ports() == [7447, 7999]
    (tmp_path / "graph.yaml").write_text("nodes: 3\n")
    finding = dict(examination.examine({"ports": network.ports}))["ports"]
    assert (finding.state, finding.mend) == ("problem", "sceneq check")


def test_round_trips_are_judged_by_their_median() -> None:
    assert network.judged([90.0, 2.0, 1.0]).found.endswith("in 2.0 ms")
    assert network.judged([90.0, 80.0]).state == "warning"
    assert network.judged([]).state == "problem"
    arrived = threading.Event()
    assert len(network.trips_ms(arrived.set, arrived)) == network.MESSAGES


def test_a_message_goes_through_a_router_of_our_own() -> None:
    assert network.round_trip().state in ("ok", "warning")


def failing() -> Finding:
    raise TypeError("odd machine")


def complaining() -> Finding:
    raise UserError("graph.yaml: no nodes\nand more")


def test_a_check_that_fails_is_told_and_the_others_too() -> None:
    checks = {"first": failing, "second": complaining, "third": lambda: ok("fine")}
    found = dict(examination.examine(checks))
    assert found["first"].found == "the check failed: TypeError: odd machine"
    assert found["first"].mend == "sceneq doctor 'first' --trace"
    assert found["second"] == problem("graph.yaml: no nodes", "sceneq check")
    assert found["third"].state is State.OK


Outcome = tuple[int, str, str]


@pytest.fixture
def run(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[..., Outcome]:
    def run_doctor(*arguments: str) -> Outcome:
        monkeypatch.setattr(sys, "argv", ["sceneq", "doctor", *arguments])
        with pytest.raises(SystemExit) as ended:
            cli.main()
        return int(ended.value.code or 0), *capsys.readouterr()

    return run_doctor


def checks(monkeypatch: pytest.MonkeyPatch, **found: Finding) -> None:
    table = {name: lambda finding=finding: finding for name, finding in found.items()}
    monkeypatch.setattr(examination, "CHECKS", table)


def test_what_is_printed_lines_up_and_ends_with_a_verdict(
    run: Callable[..., Outcome], monkeypatch: pytest.MonkeyPatch
) -> None:
    checks(monkeypatch, cores=ok("2"), clock=warning("1970", "set it"))
    assert run() == (
        0,
        "ok       cores            2\n"
        "warning  clock            1970\n"
        "                          -> set it\n"
        "\n"
        "nothing is in the way; 1 warning\n",
        "",
    )
    assert run("cores")[1].endswith("2\n\nnothing is in the way\n")


def test_a_problem_means_exit_code_1(
    run: Callable[..., Outcome], monkeypatch: pytest.MonkeyPatch
) -> None:
    checks(monkeypatch, disk=problem("full", "du"), cores=ok("2"))
    code, out, _ = run()
    assert code == 1
    assert out.endswith("1 problem to mend first\n")
    code, out, _ = run("--json")
    assert code == 1
    assert json.loads(out) == {
        "ok": False,
        "checks": [
            {"check": "disk", "state": "problem", "found": "full", "mend": "du"},
            {"check": "cores", "state": "ok", "found": "2", "mend": ""},
        ],
    }


def test_an_unknown_check_is_wrong_usage(run: Callable[..., Outcome]) -> None:
    code, out, err = run("coffee")
    assert (code, out) == (2, "")
    assert err.startswith("sceneq: no check named 'coffee' (there are: python, ")


def test_verdicts() -> None:
    assert verdict(0, 0) == "nothing is in the way"
    assert verdict(2, 1) == "2 problems to mend first; 1 warning"


def test_apt_install_says_what_to_type_when_it_may_not(tmp_path: Path) -> None:
    for name, text in {"apt-get": "exit 9", "sudo": "exit 1", "id": "echo 1000"}.items():
        (tmp_path / name).write_text(f"#!/bin/sh\n{text}\n")
        (tmp_path / name).chmod(0o755)
    done = subprocess.run(
        [ROOT / "deploy" / "apt-install", "libgl1", "libegl1"],
        env={"PATH": f"{tmp_path}:/usr/bin:/bin"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1
    assert done.stderr == "needed; run: sudo apt-get install libgl1 libegl1\n"
