"""Errors as people and programs on the web expect them: RFC 9457 problem details."""

from typing import Any

from starlette.responses import JSONResponse

from sceneq_nodes._bus import QueryError

MEDIA_TYPE = "application/problem+json"
STATUS_OF_CODE = {
    "bad_request": 400,
    "not_found": 404,
    "too_large": 502,
    "busy": 503,
    "timeout": 504,
}
TITLES = {
    400: "The request cannot be understood",
    401: "Say who you are",
    403: "Not from here",
    404: "There is no such thing",
    405: "Not done that way",
    413: "Too large",
    421: "Not this host",
    500: "This should not happen",
    502: "The answer is not one of ours",
    503: "Too busy, or not there",
    504: "No answer in time",
}


class ProblemError(Exception):
    """What is told instead of an answer."""

    def __init__(
        self, status: int, detail: str, hint: str = "", retry_s: int | None = None
    ) -> None:
        super().__init__(detail)
        self.status = status
        self.detail = detail
        self.hint = hint
        self.retry_s = retry_s

    def response(self) -> JSONResponse:
        """Return it as a response."""
        body: dict[str, Any] = {
            "type": "about:blank",
            "title": TITLES[self.status],
            "status": self.status,
            "detail": self.detail,
        }
        if self.hint:
            body["hint"] = self.hint
        headers = {} if self.retry_s is None else {"Retry-After": str(self.retry_s)}
        if self.status == 401:
            headers["WWW-Authenticate"] = "Bearer"
        return JSONResponse(body, self.status, headers, MEDIA_TYPE)


def problem_of(error: QueryError) -> ProblemError:
    """Return what an error on the bus is on the web."""
    status = STATUS_OF_CODE.get(error.code, 502)
    retry_s = None if error.retry_ms is None else max(1, -(-error.retry_ms // 1000))
    return ProblemError(status, error.message, error.hint, retry_s)
