"""A vision-language model of the Qwen-VL families in this process, through transformers.

For a robot with a GPU and no server. Several processes share a model better behind a server: see
the kind ``openai``. Pictures are prepared without torchvision.
"""

import json
import logging
import math
from collections.abc import Sequence
from concurrent.futures import Future
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from sceneq_core.reasoning.multiple_choice import RULES, VisualQuestion
from sceneq_core.reasoning.reasoner import Usage
from sceneq_core.reasoning.visual import VisualParams
from sceneq_nodes._hub import model_folder
from sceneq_nodes._timed_calls import OutOfTimeError, TimedCalls, left, wait
from sceneq_nodes._torch import chosen_device, chosen_dtype, need_device, need_dtype
from sceneq_nodes._vision_model import Replies, Tally
from sceneq_nodes._visual_reasoner import VisualReasoner
from sceneq_nodes._weights import need_package

if TYPE_CHECKING:
    import torch

log = logging.getLogger(__name__)

FAILURES = (OutOfTimeError, OSError, ValueError, RuntimeError)
"""What loading and generating end in; running out of a GPU's memory is a ``RuntimeError``."""
MAX_SAID_CHARS = 200
FAMILIES = ("qwen2_vl", "qwen2_5_vl", "qwen3_vl", "qwen3_vl_moe")


@dataclass(frozen=True, slots=True)
class TransformersReasonerParams:
    """``model``: folder or hub name, at ``revision``. ``device``: auto, cpu, cuda or cuda:N;
    ``dtype``: auto (bfloat16 on a GPU, float32 on a CPU), float32, float16 or bfloat16.
    """

    model: str
    revision: str = "main"
    device: str = "auto"
    dtype: str = "auto"
    visual: VisualParams = field(default_factory=VisualParams)

    def __post_init__(self) -> None:
        need_device(self)
        need_dtype(self)


class TransformersReasoner(VisualReasoner):
    """Asks a model in this process."""

    Params: ClassVar[type] = TransformersReasonerParams

    def __init__(self, params: TransformersReasonerParams) -> None:
        super().__init__(params.visual, LocalModel(params))


@dataclass(frozen=True, slots=True, eq=False)
class _Loaded:
    """The model with what turns a question into its numbers and its numbers into text."""

    model: Any
    tokenizer: Any
    pictures: Any


class LocalModel:
    """Loads beside the node's start, then answers one question after the other."""

    def __init__(self, params: TransformersReasonerParams) -> None:
        """Look at what is there; raise ``ValueError`` when the model cannot be used."""
        need_package("transformers", "transformers", "transformers")
        if Path(params.model).expanduser().is_dir():
            _check_family(model_folder(params.model))
        self.name = Path(params.model).name
        self._params = params
        self._calls = TimedCalls(1)
        self._loaded: Future[_Loaded] = TimedCalls(1).start(self._load, math.inf)

    def ask(self, questions: Sequence[VisualQuestion], end_s: float) -> Replies:
        """Return the replies that are ready in time."""
        tally = Tally()
        try:
            loaded = self._ready(end_s)
        except FAILURES as error:
            return Replies((), (self._said(error),), *tally.total())
        started = [
            self._calls.start(partial(self._reply, loaded, question, end_s, tally), end_s)
            for question in questions
        ]
        texts, failures = [], []
        for future in started:
            try:
                texts.append(wait(future, end_s))
            except FAILURES as error:
                failures.append(self._said(error))
        return Replies(tuple(texts), tuple(failures), *tally.total())

    def close(self) -> None:
        """The weights go with the process."""

    def _said(self, error: Exception) -> str:
        said = " ".join(str(error).split()) or type(error).__name__
        return f"{self.name}: {said[:MAX_SAID_CHARS]}"

    def _reply(self, loaded: _Loaded, question: VisualQuestion, end_s: float, tally: Tally) -> str:
        import torch

        fed = _fed(loaded, question)
        asked = int(fed["input_ids"].shape[1])
        tally.add(Usage(tokens_in=asked), calls=1)
        replies = _possible_replies(loaded.tokenizer, question)
        with torch.inference_mode():
            told = loaded.model.generate(
                **fed,
                max_new_tokens=max(map(len, replies)),
                do_sample=False,
                max_time=max(left(end_s), 1e-3),
                prefix_allowed_tokens_fn=partial(_next_tokens, replies, asked),
            )[0, asked:]
        tally.add(Usage(tokens_out=len(told)))
        text: str = loaded.tokenizer.decode(told, skip_special_tokens=True)
        return text

    def _ready(self, end_s: float) -> _Loaded:
        try:
            return wait(self._loaded, end_s)
        except OutOfTimeError:
            raise OutOfTimeError("the model is still loading") from None

    def _load(self) -> _Loaded:
        try:
            return _load(self._params)
        except Exception:
            log.exception("the model %s could not be loaded", self._params.model)
            raise


def _load(params: TransformersReasonerParams) -> _Loaded:
    from transformers import (
        AutoModelForImageTextToText,
        AutoTokenizer,
        Qwen2VLImageProcessorPil,
    )

    folder = model_folder(params.model, params.revision)
    _check_family(folder)
    device = chosen_device(params.device)
    model: Any = AutoModelForImageTextToText.from_pretrained(
        folder, dtype=_dtype(params.dtype, device)
    )
    pictures = Qwen2VLImageProcessorPil.from_pretrained(folder)
    model.to(device=device).eval()
    return _Loaded(model, AutoTokenizer.from_pretrained(folder), pictures)


def _dtype(dtype: str, device: "torch.device") -> "torch.dtype":
    """These models were trained in bfloat16 and overflow in float16."""
    on_gpu = dtype == "auto" and device.type == "cuda"
    return chosen_dtype("bfloat16" if on_gpu else dtype, device)


def _check_family(folder: Path) -> None:
    path = folder / "config.json"
    try:
        kind = json.loads(path.read_text(encoding="utf-8")).get("model_type")
    except (OSError, ValueError, AttributeError) as error:
        raise ValueError(f"{path}: no config of a model of transformers: {error}") from error
    if kind not in FAMILIES:
        known = ", ".join(FAMILIES)
        raise ValueError(f"{path}: model_type: expected {known}, got {kind!r}; see kind openai")


def _possible_replies(tokenizer: Any, question: VisualQuestion) -> list[list[int]]:
    """Return the tokens of every allowed reply: nothing else can be said."""
    end = [tokenizer.eos_token_id]
    texts = [json.dumps({"choice": key}) for key in question.keys]
    return [list(tokenizer(text)["input_ids"]) + end for text in texts]


def _next_tokens(
    replies: Sequence[list[int]], asked: int, _batch: int, ids: "torch.Tensor"
) -> list[int]:
    """Return what may come after ``ids``, of which the first ``asked`` are the question."""
    said = ids[asked:].tolist()
    going_on = [r for r in replies if len(r) > len(said) and r[: len(said)] == said]
    return sorted({reply[len(said)] for reply in going_on}) or [replies[0][-1]]


def _fed(loaded: _Loaded, question: VisualQuestion) -> dict[str, Any]:
    """Return the model's inputs: every picture's place in the text as long as its patches."""
    import torch

    images = [{"type": "image"}] * len(question.pictures)
    text = loaded.tokenizer.apply_chat_template(
        [
            {"role": "system", "content": RULES},
            {"role": "user", "content": [*images, {"type": "text", "text": question.text}]},
        ],
        tokenize=False,
        add_generation_prompt=True,
    )
    seen = loaded.pictures(images=list(question.pictures), return_tensors="pt")
    lengths = (seen["image_grid_thw"].prod(dim=1) // loaded.pictures.merge_size**2).tolist()
    place = loaded.model.config.image_token_id
    ids = torch.tensor([_spread(loaded.tokenizer(text)["input_ids"], place, lengths)])
    fed = {
        "input_ids": ids,
        "attention_mask": torch.ones_like(ids),
        "mm_token_type_ids": (ids == place).int(),
        "image_grid_thw": seen["image_grid_thw"],
        "pixel_values": seen["pixel_values"].to(loaded.model.dtype),
    }
    return {name: value.to(loaded.model.device) for name, value in fed.items()}


def _spread(ids: Sequence[int], place: int, lengths: Sequence[int]) -> list[int]:
    """Return ``ids`` with the n-th ``place`` repeated ``lengths[n]`` times."""
    if list(ids).count(place) != len(lengths):
        raise ValueError(f"the chat template has {list(ids).count(place)} places for pictures")
    remaining = iter(lengths)
    spread: list[int] = []
    for token in ids:
        spread += [token] * (next(remaining) if token == place else 1)
    return spread
