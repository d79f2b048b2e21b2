"""Reasoners behind a chat server, and the refusal that is expected of them."""

from contextlib import ExitStack, contextmanager

import pytest

from sceneq_core.reasoning.reasoner import UnansweredError
from sceneq_nodes._backends import build

from support.seen_things import keyframe, which_mug


@contextmanager
def reasoners():
    """Build reasoners for a server's URL; they are closed in the end."""
    with ExitStack() as opened:

        def make(url, **params):
            chat = {"backoff_s": 0.001, **params.pop("chat", {})}
            spec = {"kind": "openai", "base_url": url, "model": "m", "chat": chat, **params}
            built = build("reasoner", spec)
            opened.callback(built.close)
            return built

        yield make


def unanswered(built, problem=None, pictures=keyframe):
    with pytest.raises(UnansweredError) as caught:
        built.solve(problem or which_mug(), pictures)
    return caught.value
