"""A vision-language model behind any OpenAI-compatible server: vLLM, Ollama, llama.cpp, LM Studio.

The key is read from the environment and leaves the process in one header only.
"""

import os
from collections.abc import Sequence
from concurrent.futures import Future
from dataclasses import dataclass, field
from functools import partial
from typing import ClassVar
from urllib.parse import urlsplit

from sceneq_core.checks import need_within
from sceneq_core.reasoning.multiple_choice import VisualQuestion
from sceneq_core.reasoning.visual import VisualParams, read_choices
from sceneq_core.routing.budget import Budget
from sceneq_nodes._accounting import Ledger, Prices
from sceneq_nodes._chat_client import CallError, ChatClient, ChatParams
from sceneq_nodes._circuit_breaker import BreakerParams, CircuitBreaker, OpenCircuitError
from sceneq_nodes._shared_calls import SharedCalls
from sceneq_nodes._timed_calls import OutOfTimeError, TimedCalls, left, wait
from sceneq_nodes._vision_model import Replies, Tally
from sceneq_nodes._visual_reasoner import VisualReasoner


@dataclass(frozen=True, slots=True)
class OpenAiParams:
    """``base_url`` such as ``http://127.0.0.1:11434/v1`` and the ``model``'s name there.

    ``key_env`` names the environment variable with the key; "" = the server wants none.
    ``concurrency``: calls at a time. ``remembered``: replies that are kept, so that the same
    question about the same pictures is paid once; 0 = none.
    """

    base_url: str
    model: str
    key_env: str = ""
    concurrency: int = 4
    remembered: int = 256
    chat: ChatParams = field(default_factory=ChatParams)
    breaker: BreakerParams = field(default_factory=BreakerParams)
    prices: Prices = field(default_factory=Prices)
    budget: Budget = field(default_factory=Budget)
    visual: VisualParams = field(default_factory=VisualParams)

    def __post_init__(self) -> None:
        parts = urlsplit(self.base_url)
        if parts.scheme not in ("http", "https") or not parts.hostname or parts.port == 0:
            raise ValueError("base_url: expected http://HOST:PORT/v1 or https://HOST/v1")
        if parts.username or parts.password or parts.query:
            raise ValueError("base_url: a key belongs into the environment, see key_env")
        if not self.model:
            raise ValueError("model: expected the name that the server knows the model by")
        need_within(self, 1, 64, "concurrency")
        need_within(self, 0, 100_000, "remembered")


class OpenAiReasoner(VisualReasoner):
    """Asks a server; what it cannot be asked or does not tell in time is ``UnansweredError``."""

    Params: ClassVar[type] = OpenAiParams

    def __init__(self, params: OpenAiParams) -> None:
        super().__init__(params.visual, ChatModel(params))


class ChatModel:
    """A model on a server, asked in parallel, guarded by deadline, breaker and budget."""

    def __init__(self, params: OpenAiParams) -> None:
        self.name = params.model
        self._ledger = Ledger(params.prices, params.budget)
        self._client = ChatClient(
            params.base_url, params.model, key_from(params.key_env), params.chat, self._ledger
        )
        self._breaker = CircuitBreaker(params.breaker)
        self._calls = TimedCalls(params.concurrency)
        self._shared = SharedCalls(params.remembered)

    def ask(self, questions: Sequence[VisualQuestion], end_s: float) -> Replies:
        """Return the replies to all questions, asked at once."""
        tally = Tally()
        started = [self._start(question, end_s, tally) for question in questions]
        texts, failures = [], []
        for question, (future, own) in zip(questions, started, strict=True):
            try:
                texts.append(self._result(question, future, own, end_s, tally))
            except (CallError, OpenCircuitError, OutOfTimeError) as error:
                failures.append(f"{self.name}: {error}")
        return Replies(tuple(texts), tuple(failures), *tally.total())

    def _start(
        self, question: VisualQuestion, end_s: float, tally: Tally
    ) -> tuple["Future[str]", bool]:
        """Ask, unless the same is under way or known; return whether it is a call of our own."""
        return self._shared.start(
            self._client.key(question),
            lambda: self._calls.start(partial(self._reply, question, end_s, tally), end_s),
            lambda text: bool(read_choices(question, [text])[0]),
        )

    def _result(
        self,
        question: VisualQuestion,
        future: "Future[str]",
        own: bool,
        end_s: float,
        tally: Tally,
    ) -> str:
        """Wait for the reply; when another's call fails, perhaps for want of time, ask again."""
        try:
            return wait(future, end_s)
        except (CallError, OpenCircuitError, OutOfTimeError):
            if own or not left(end_s):
                raise
        return wait(self._start(question, end_s, tally)[0], end_s)

    def close(self) -> None:
        """Close the connections."""
        self._client.close()

    def _reply(self, question: VisualQuestion, end_s: float, tally: Tally) -> str:
        """Ask one question and tell the breaker how it went."""
        self._breaker.enter()
        try:
            text = self._client.reply(question, end_s, tally)
        except CallError as error:
            if error.servers:
                self._breaker.failed(str(error))
            raise
        self._breaker.succeeded()
        return text


def key_from(variable: str) -> str:
    """Return the key in an environment variable; "" when none is named.

    Raises:
        ValueError: the variable is not set, or holds what cannot be a key. Never says the key.
    """
    if not variable:
        return ""
    key = os.environ.get(variable, "").strip()
    if not key:
        raise ValueError(f"key_env: the environment variable {variable} is not set")
    if not (key.isascii() and key.isprintable()) or " " in key:
        raise ValueError(f"key_env: the value of {variable} cannot be a key: it has odd characters")
    return key
