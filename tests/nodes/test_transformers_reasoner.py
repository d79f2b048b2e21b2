"""The reasoner with a model in this process: refusals, deadlines and what it is fed."""

import json
import math
import threading

import pytest

from sceneq_core.reasoning.reasoner import UnansweredError
from sceneq_nodes import _transformers_reasoner
from sceneq_nodes._backends import build
from sceneq_nodes._params import ParamError

from support.seen_things import keyframe, what_is_it, which_mug
from support.tiny_vlm import write_tiny_vlm

pytest.importorskip("transformers", reason="the kind 'transformers' is an extra")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return write_tiny_vlm(tmp_path_factory.mktemp("vlm"))


def reasoner(folder, **params):
    spec = {"kind": "transformers", "model": str(folder), "device": "cpu", **params}
    return build("reasoner", spec)


def test_it_chooses_one_of_the_boxes(folder):
    verdict = reasoner(folder).solve(which_mug(time_s=math.inf), keyframe)
    assert {instance_id for instance_id, _ in verdict.ranking} in ({7, 4, 9}, set())
    assert verdict.reason.startswith(f"{folder.name} chose ")
    assert verdict.vlm_calls == 1
    patches = 2 * 4 * 6  # two pictures of 120 x 160 in tokens of 28 x 28 pixels, rounded
    assert patches < verdict.usage.tokens_in < 1200
    assert 5 < verdict.usage.tokens_out < 40


def test_every_view_has_a_vote(folder):
    verdict = reasoner(folder).label(what_is_it(time_s=math.inf), keyframe)
    assert verdict.vlm_calls == 3
    assert " of 3 views say " in verdict.reason


def test_while_the_model_loads_questions_are_answered_without_it(folder, monkeypatch):
    go_on = threading.Event()
    monkeypatch.setattr(_transformers_reasoner, "_load", lambda params: go_on.wait(60))
    with pytest.raises(UnansweredError, match=r"vlm.: the model is still loading") as caught:
        reasoner(folder).solve(which_mug(time_s=1.0), keyframe)
    assert caught.value.vlm_calls == 0
    go_on.set()


def test_a_model_without_weights_fails_with_the_reason(folder, tmp_path):
    for name in ("config.json", "tokenizer.json", "tokenizer_config.json"):
        (tmp_path / name).write_bytes((folder / name).read_bytes())
    with pytest.raises(UnansweredError, match="safetensors"):
        reasoner(tmp_path).solve(which_mug(time_s=math.inf), keyframe)


@pytest.mark.parametrize(
    ("config", "message"),
    [
        ({"model_type": "llava"}, "expected qwen2_vl, .* got 'llava'; see kind openai"),
        ([], "no config of a model"),
    ],
)
def test_a_model_of_another_family_is_refused_at_once(tmp_path, config, message):
    (tmp_path / "config.json").write_text(json.dumps(config))
    with pytest.raises(ValueError, match=message):
        reasoner(tmp_path)


@pytest.mark.parametrize("change", [{"device": "tpu"}, {"dtype": "int3"}])
def test_parameters_are_checked(folder, change):
    with pytest.raises(ParamError, match=next(iter(change))):
        reasoner(folder, **change)
