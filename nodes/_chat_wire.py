"""The JSON of OpenAI's chat completions, as every compatible server speaks it."""

import base64
import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from sceneq_core.arrays import UInt8
from sceneq_core.reasoning.multiple_choice import RULES, VisualQuestion
from sceneq_core.views.jpeg import jpeg_from_rgb

CHARS_PER_TOKEN = 4
PIXELS_PER_TOKEN = 28 * 28
"""Of Qwen2.5-VL; only for servers that do not count themselves."""


class BadReplyError(ValueError):
    """A body that is no chat completion; the text says what is wrong with it.

    ``passing``: it may be right the next time.
    """

    passing = True


class CutOffError(BadReplyError):
    """The model has used up its tokens without an answer, as it would again."""

    passing = False


@dataclass(frozen=True, slots=True)
class Completion:
    """The text of the first choice, and the tokens as the server counts them, if it does."""

    text: str
    tokens: tuple[int, int] | None


def request_body(
    question: VisualQuestion,
    model: str,
    max_tokens: int,
    changes: Mapping[str, Any],
    *,
    structured: bool,
) -> bytes:
    """Return the request for one question; ``structured`` leaves only the choices as a reply.

    ``changes`` are set last; ``None`` removes a key.
    """
    body: dict[str, Any] = {
        "model": model,
        "messages": [
            {"role": "system", "content": RULES},
            {"role": "user", "content": [*map(_image, question.pictures), _text(question.text)]},
        ],
        "max_tokens": max_tokens,
        "temperature": 0,
    }
    if structured:
        body["response_format"] = {
            "type": "json_schema",
            "json_schema": {"name": "choice", "strict": True, "schema": question.schema()},
        }
    changed = {**body, **changes}
    return json.dumps({key: value for key, value in changed.items() if value is not None}).encode()


def completion_from_bytes(data: bytes) -> Completion:
    """Return the completion in a reply's body; raise ``BadReplyError``."""
    try:
        body = json.loads(data)
    except (ValueError, RecursionError) as error:
        raise BadReplyError(f"the reply is not JSON: {error}") from error
    choices = body.get("choices") if isinstance(body, dict) else None
    if not isinstance(choices, list) or not choices:
        raise BadReplyError("the reply has no choices")
    first = choices[0] if isinstance(choices[0], dict) else {}
    message = first.get("message")
    text = _content(message.get("content")) if isinstance(message, dict) else ""
    if not text.strip():
        if first.get("finish_reason") == "length":
            raise CutOffError("max_tokens were used up before anything was said")
        raise BadReplyError("the reply has no text")
    return Completion(text, _tokens(body.get("usage")))


def estimated_tokens(question: VisualQuestion, text: str) -> tuple[int, int]:
    """Return about how many tokens a question and its reply take."""
    pixels = sum(rgb.shape[0] * rgb.shape[1] for rgb in question.pictures)
    asked = (len(RULES) + len(question.text)) // CHARS_PER_TOKEN + pixels // PIXELS_PER_TOKEN
    return asked, len(text) // CHARS_PER_TOKEN + 1


def _image(rgb: UInt8) -> dict[str, Any]:
    data = base64.b64encode(jpeg_from_rgb(rgb)).decode()
    return {"type": "image_url", "image_url": {"url": f"data:image/jpeg;base64,{data}"}}


def _text(text: str) -> dict[str, Any]:
    return {"type": "text", "text": text}


def _content(content: Any) -> str:
    """Return the text of a message, which some servers send in parts."""
    if isinstance(content, str):
        return content
    parts = content if isinstance(content, list) else []
    texts = [part.get("text") for part in parts if isinstance(part, dict)]
    return "".join(text for text in texts if isinstance(text, str))


def _tokens(usage: Any) -> tuple[int, int] | None:
    if not isinstance(usage, dict):
        return None
    tokens = usage.get("prompt_tokens"), usage.get("completion_tokens")
    counted = [count for count in tokens if type(count) is int and 0 <= count < 2**40]
    return (counted[0], counted[1]) if len(counted) == 2 else None
