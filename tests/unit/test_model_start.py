"""A node has to be back soon after it was killed: what is heavy loads when it is first used."""

import subprocess
import sys

import pytest

from support.tiny_segmenters import network_spec
from support.tiny_towers import encoder_spec

HEAVY = ("torch", "transformers", "onnxruntime", "huggingface_hub")
BUILD = """
import sys
from sceneq_nodes._backends import build
build({seam!r}, {spec!r})
print([name for name in {heavy!r} if name in sys.modules])
"""


@pytest.mark.parametrize(
    ("seam", "kind"),
    [
        ("encoder", "transformers"),
        ("encoder", "onnx"),
        ("segmenter", "sam"),
        ("segmenter", "onnx"),
    ],
)
def test_building_loads_nothing_heavy(seam, kind, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    if seam == "encoder":
        spec = encoder_spec(kind, tmp_path)
    else:
        spec = {"kind": kind, **network_spec(kind, tmp_path)}
    code = BUILD.format(seam=seam, spec=spec, heavy=HEAVY)
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert run.stdout == "[]\n", run.stderr
