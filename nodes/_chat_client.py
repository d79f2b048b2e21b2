"""One question to a chat server: HTTP with a deadline, bounded retries and an honest bill."""

import email.utils
import hashlib
import logging
import random
import time
from dataclasses import dataclass, field
from typing import Any

import httpx2

from sceneq_core.checks import need_positive, need_within
from sceneq_core.reasoning.multiple_choice import VisualQuestion
from sceneq_core.routing.budget import OverBudgetError
from sceneq_nodes._accounting import Ledger
from sceneq_nodes._chat_wire import (
    BadReplyError,
    Completion,
    completion_from_bytes,
    estimated_tokens,
    request_body,
)
from sceneq_nodes._timed_calls import left
from sceneq_nodes._vision_model import Tally

log = logging.getLogger(__name__)

MAX_REPLY_BYTES = 1024 * 1024
MAX_SAID_CHARS = 200
PASSING = frozenset({408, 425, 429, 500, 502, 503, 504})
UNSUPPORTED = frozenset({400, 415, 422, 501})


@dataclass(frozen=True, slots=True)
class ChatParams:
    """``timeout_s``: the longest that one call may take, also when the question has more time.

    A server that had less than ``fair_s`` is not blamed for being late.
    ``retries`` after failures that pass (429, 5xx, a cut connection, a reply that is none), each
    after a random wait of at most ``backoff_s``, twice that, ...; ``max_tokens`` of a reply:
    a choice takes ten, a model that thinks aloud hundreds. ``body``: keys of the
    request to set, or with null to leave out, such as ``{max_tokens: null}``.
    """

    timeout_s: float = 20.0
    fair_s: float = 2.0
    retries: int = 2
    backoff_s: float = 0.5
    max_tokens: int = 64
    body: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        need_positive(self, "timeout_s", "fair_s", "backoff_s")
        need_within(self, 0, 10, "retries")
        need_within(self, 1, 32768, "max_tokens")


class CallError(Exception):
    """A call without a usable reply; ``wait_s`` is what the server asked for before the next.

    ``passing``: it may go better at once. ``servers``: it says something about the server, so the
    circuit breaker should hear of it.
    """

    def __init__(
        self, why: str, *, passing: bool, servers: bool = True, wait_s: float | None = None
    ) -> None:
        super().__init__(why)
        self.passing = passing
        self.servers = servers
        self.wait_s = wait_s


class UnsupportedError(CallError):
    """The server refuses the request as it stands, perhaps only its ``response_format``."""


class NotSentError(CallError):
    """The server could not be reached: nothing was asked, nothing is to be paid."""


class _LateError(Exception):
    """The time is up in the middle of a reply."""


class ChatClient:
    """Talks to ``<base_url>/chat/completions``; safe to use from several threads."""

    def __init__(
        self, base_url: str, model: str, key: str, params: ChatParams, ledger: Ledger
    ) -> None:
        self._url = base_url.rstrip("/") + "/chat/completions"
        self._model = model
        self._key = key
        self._params = params
        self._ledger = ledger
        self._structured = True
        self._random = random.Random()
        headers = {"Content-Type": "application/json"}
        self._http = httpx2.Client(
            headers=headers | ({"Authorization": f"Bearer {key}"} if key else {})
        )

    def reply(self, question: VisualQuestion, end_s: float, tally: Tally) -> str:
        """Return the text of the reply, before ``end_s`` on the clock ``time.monotonic``.

        Raises:
            CallError: there is none, and why; without the key, whatever the server says.
        """
        attempt = 0
        while True:
            try:
                return self._ask(question, end_s, tally)
            except CallError as error:
                wait_s = self._wait_s(error, attempt)
                if not error.passing or attempt == self._params.retries:
                    raise
                if wait_s >= left(end_s):
                    raise CallError(f"{error}; no time for another try", passing=False) from error
                time.sleep(wait_s)
            attempt += 1

    def close(self) -> None:
        """Close the connections."""
        self._http.close()

    def key(self, question: VisualQuestion) -> bytes:
        """Return what tells two requests apart: every byte of them, pictures included."""
        return hashlib.sha256(self._body(question, structured=True)).digest()

    def _wait_s(self, error: CallError, attempt: int) -> float:
        """Return how long to wait: as asked, or at random so that not all come back together."""
        if error.wait_s is not None:
            return error.wait_s
        return self._random.uniform(0, self._params.backoff_s * 2**attempt)

    def _ask(self, question: VisualQuestion, end_s: float, tally: Tally) -> str:
        """Ask once; a server that refuses the form of the reply is asked for plain text."""
        if self._structured:
            try:
                return self._call(question, end_s, tally, structured=True)
            except UnsupportedError as error:
                text = self._call(question, end_s, tally, structured=False)
                log.warning("%s takes no response_format (%s): plain text it is", self._url, error)
                self._structured = False
                return text
        return self._call(question, end_s, tally, structured=False)

    def _call(
        self, question: VisualQuestion, end_s: float, tally: Tally, *, structured: bool
    ) -> str:
        """Make one call and book it, also when it fails: a server may count it all the same."""
        body = self._body(question, structured=structured)
        self._begin(end_s, tally)
        try:
            completion = self._post(body, min(end_s, time.monotonic() + self._params.timeout_s))
        except NotSentError:
            tally.add(self._ledger.cancel_call(), calls=-1)
            raise
        tokens = completion.tokens or estimated_tokens(question, completion.text)
        tally.add(self._ledger.end_call(*tokens))
        return completion.text

    def _body(self, question: VisualQuestion, *, structured: bool) -> bytes:
        params = self._params
        return request_body(
            question, self._model, params.max_tokens, params.body, structured=structured
        )

    def _begin(self, end_s: float, tally: Tally) -> None:
        if not left(end_s):
            raise CallError("no time left to ask", passing=False, servers=False)
        try:
            tally.add(self._ledger.begin_call(), calls=1)
        except OverBudgetError as error:
            raise CallError(str(error), passing=False, servers=False) from error

    def _post(self, body: bytes, end_s: float) -> Completion:
        time_s = left(end_s)
        try:
            with self._http.stream(
                "POST", self._url, content=body, timeout=max(time_s, 1e-3)
            ) as response:
                data = _read(response, end_s)
                self._check(response, data)
            return completion_from_bytes(data)
        except (httpx2.ConnectError, httpx2.ConnectTimeout, httpx2.PoolTimeout) as error:
            raise NotSentError(f"cannot reach {self._url}: {error}", passing=True) from error
        except (httpx2.TimeoutException, _LateError) as error:
            fair = time_s >= self._params.fair_s
            raise CallError("no reply in time", passing=True, servers=fair) from error
        except httpx2.HTTPError as error:
            why = f"the connection failed: {self._clean(str(error)) or type(error).__name__}"
            raise CallError(why, passing=True) from error
        except BadReplyError as error:
            raise CallError(self._clean(str(error)), passing=error.passing) from error

    def _check(self, response: httpx2.Response, data: bytes) -> None:
        status = response.status_code
        if 200 <= status < 300:
            return
        why = f"HTTP {status}: {self._clean(data[: 4 * MAX_SAID_CHARS].decode(errors='replace'))}"
        if status in UNSUPPORTED:
            raise UnsupportedError(why, passing=False)
        wait_s = _retry_after_s(response.headers.get("Retry-After", ""))
        raise CallError(why, passing=status in PASSING, wait_s=wait_s)

    def _clean(self, text: str) -> str:
        """Return what a server says in one short line, without the key that it may quote."""
        text = text.replace(self._key, "***") if self._key else text
        return " ".join(text.split())[:MAX_SAID_CHARS]


def _read(response: httpx2.Response, end_s: float) -> bytes:
    """Return the body; the limits hold for all of it, the library's only for a single read."""
    data = bytearray()
    for chunk in response.iter_bytes():
        data += chunk
        if len(data) > MAX_REPLY_BYTES:
            raise CallError(f"the reply is longer than {MAX_REPLY_BYTES} bytes", passing=False)
        if not left(end_s):
            raise _LateError
    return bytes(data)


def _retry_after_s(text: str) -> float | None:
    """Return the seconds in a ``Retry-After``, given as such or as a date; ``None`` without."""
    if text.isascii() and text.strip().isdigit():
        return float(text[:9])
    try:
        return max(0.0, email.utils.parsedate_to_datetime(text).timestamp() - time.time())
    except (ValueError, OverflowError):
        return None
