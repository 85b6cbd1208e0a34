"""What the client raises. A problem that the service answers keeps its type, field, value and remedy."""

from collections.abc import Mapping
from typing import Any


class ClientError(Exception):
    """Anything that this client raises by itself."""


class UnreachableError(ClientError):
    """The service does not answer: address, port, or it is not running."""


class ProblemError(ClientError):
    """The service answered with a problem (RFC 9457).

    Attributes:
        type: stable name of the kind of problem, for example `/problems/lease`.
        status: HTTP status.
        title: the kind of problem in a few words.
        detail: what happened.
        field: what of the request is wrong, None where nothing is.
        value: what stood there.
        remedy: what to do about it.
    """

    def __init__(self, problem: Mapping[str, Any]) -> None:  # JSON values
        self.type: str = problem.get("type", "about:blank")
        self.status: int = problem.get("status", 0)
        self.title: str = problem.get("title", "")
        self.detail: str = problem.get("detail", "")
        self.field: str | None = problem.get("field")
        self.value: str | None = problem.get("value")
        self.remedy: str = problem.get("remedy", "")
        words = self.detail or self.title or f"HTTP status {self.status}"
        super().__init__(f"{words} (remedy: {self.remedy})" if self.remedy else words)


class AccessError(ProblemError):
    """No valid token, or one that may not do this."""


class NotFoundError(ProblemError):
    """There is no such thing."""


class ConflictError(ProblemError):
    """Not possible in the present state."""


class LeaseLostError(ConflictError):
    """The rig's lease is held by somebody else, or has ended."""


class InvalidError(ProblemError):
    """The request is wrong: look at `field`, `value` and `remedy`."""


class UnavailableError(ProblemError):
    """The service or the rig failed."""


class NotDoneError(ClientError):
    """A session, campaign or analysis ended otherwise than done, or not in time.

    Attributes:
        state: where it stands.
    """

    def __init__(self, message: str, state: str) -> None:
        super().__init__(message)
        self.state = state


_BY_TYPE: Mapping[str, type[ProblemError]] = {"/problems/lease": LeaseLostError}
_BY_STATUS: Mapping[int, type[ProblemError]] = {
    401: AccessError,
    403: AccessError,
    404: NotFoundError,
    409: ConflictError,
    413: InvalidError,
    422: InvalidError,
}


def make_problem(problem: Mapping[str, Any]) -> ProblemError:  # JSON values
    """Return the error for a problem document."""
    status = problem.get("status", 0)
    fallback = UnavailableError if status >= 500 else ProblemError
    kind = _BY_TYPE.get(problem.get("type", "")) or _BY_STATUS.get(status, fallback)
    return kind(problem)
