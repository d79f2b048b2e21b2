"""A key that a node answers: queries come on zenoh's thread and are answered on the pool's."""

import logging
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

from sceneq_nodes._bus import Handler, QueryError, Reply, Request
from sceneq_nodes._counters import Counters
from sceneq_nodes._logs import about_query
from sceneq_nodes._queries import (
    ERROR_ENCODING,
    QueryPool,
    answer,
    error_bytes,
    parse_parameters,
)
from sceneq_schemas.topics import Topic

log = logging.getLogger(__name__)

MAX_REQUEST_BYTES = 1024 * 1024


@dataclass(frozen=True, slots=True)
class Served:
    """One key; every query is finished with a reply, an error or nothing."""

    topic: Topic
    key: str
    ids: Mapping[str, str]
    handler: Handler
    pool: QueryPool
    counters: Counters

    def accept(self, query: Any) -> None:
        """On zenoh's thread: hand a ``zenoh.Query`` over to the pool, or refuse it at once."""
        try:
            self.pool.submit(partial(self._respond, query))
        except QueryError as busy:
            self.counters.count("queries_refused")
            with query:
                query.reply_err(error_bytes(busy), encoding=ERROR_ENCODING)

    def _respond(self, query: Any) -> None:
        attachment = query.attachment
        with query, about_query(None if attachment is None else attachment.to_bytes()):
            outcome = self._outcome(query)
            self.counters.topic(self.topic.name, "in")
            if isinstance(outcome, QueryError):
                self.counters.count(f"{self.topic.name}_errors")
                log.info("%s: %s", self.key, outcome)
                query.reply_err(error_bytes(outcome), encoding=ERROR_ENCODING)
            elif outcome is not None:
                query.reply(self.key, outcome.payload, encoding=outcome.encoding)
                self.counters.topic(self.topic.name, "out")

    def _outcome(self, query: Any) -> Reply | QueryError | None:
        size = 0 if query.payload is None else len(query.payload)
        if size > MAX_REQUEST_BYTES:
            return QueryError("too_large", f"{size} bytes, the limit is {MAX_REQUEST_BYTES}")
        return answer(self.handler, self._request(query))

    def _request(self, query: Any) -> Request:
        return Request(
            topic=self.topic,
            key=self.key,
            ids=self.ids,
            wildcard=str(query.key_expr) != self.key,
            parameters=parse_parameters(str(query.parameters)),
            payload=b"" if query.payload is None else query.payload.to_bytes(),
            encoding="" if query.encoding is None else str(query.encoding),
        )
