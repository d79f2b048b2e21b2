"""The reasoner against a server that others wrote: ``transformers serve`` with a tiny LLaVA."""

import importlib.util
import os
import subprocess
import sys
import time

import httpx2
import pytest

from sceneq_core.reasoning.reasoner import UnansweredError
from sceneq_nodes._backends import build

from support.live_graph import free_port
from support.seen_things import keyframe, what_is_it, which_mug
from support.tiny_llava import write_tiny_llava

NEEDED = ("transformers", "fastapi", "uvicorn", "openai", "accelerate")
MISSING = [name for name in NEEDED if importlib.util.find_spec(name) is None]

pytestmark = [
    pytest.mark.integration,
    pytest.mark.skipif(
        bool(MISSING), reason=f"transformers serve needs {', '.join(MISSING)}: pip install them"
    ),
]


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    """Serve a model that answers 2 whatever it is asked; yield its process, URL and name."""
    folder = write_tiny_llava(tmp_path_factory.mktemp("llava"), says="2")
    port = free_port()
    command = ["-m", "transformers.cli.transformers", "serve", str(folder)]
    log = folder.parent / "serve.log"
    with log.open("wb") as output:
        process = subprocess.Popen(
            [
                sys.executable,
                *command,
                "--host",
                "127.0.0.1",
                "--port",
                str(port),
                "--device",
                "cpu",
            ],
            stdout=output,
            stderr=subprocess.STDOUT,
            env={**os.environ, "HF_HUB_OFFLINE": "1", "OMP_NUM_THREADS": "1"},
        )
    url = f"http://127.0.0.1:{port}"
    try:
        wait_until_healthy(process, url, log)
        yield process, f"{url}/v1", str(folder)
    finally:
        process.kill()
        process.wait()


def wait_until_healthy(process, url, log):
    end_s = time.monotonic() + 90
    while time.monotonic() < end_s and process.poll() is None:
        try:
            if httpx2.get(f"{url}/health", timeout=2).status_code == 200:
                return
        except httpx2.TransportError:
            time.sleep(0.2)
    pytest.fail(f"the server did not start: {log.read_text()[-2000:]}")


@pytest.fixture
def reasoner(server):
    _, url, model = server
    chat = {"max_tokens": 8, "timeout_s": 60.0}
    built = build("reasoner", {"kind": "openai", "base_url": url, "model": model, "chat": chat})
    yield built
    built.close()


def test_it_chooses_a_box(reasoner):
    verdict = reasoner.solve(which_mug(time_s=60.0), keyframe)
    assert verdict.ranking[0][0] == 4  # the instance in box 2
    assert verdict.reason.endswith("chose instance 4 in 2 pictures")
    assert verdict.vlm_calls == 1
    assert verdict.usage.tokens_in > 2 * 4  # as the server counts: four for each picture, and text
    assert verdict.usage.tokens_out == 8


def test_it_names_a_thing_from_every_view(reasoner):
    verdict = reasoner.label(what_is_it(time_s=60.0), keyframe)
    assert verdict.ranking[0][0] == "cup"
    assert verdict.reason.startswith("3 of 3 views say 'cup'")


def test_a_model_that_the_server_does_not_have_is_its_word(server):
    _, url, _ = server
    built = build("reasoner", {"kind": "openai", "base_url": url, "model": "no/such"})
    with pytest.raises(UnansweredError, match="HTTP "):
        built.solve(which_mug(time_s=60.0), keyframe)
    built.close()


def test_a_killed_server_is_a_reason_within_the_deadline(server, reasoner):
    process, _, _ = server
    process.kill()
    process.wait()
    with pytest.raises(UnansweredError, match="cannot reach"):
        reasoner.solve(which_mug(time_s=20.0), keyframe)
