"""What the service's own rules refuse; `server/api/problems.py` turns each into a problem document."""

from sqlalchemy.exc import (
    OperationalError as StorageError,
)  # the database does not answer, is full, or is locked

__all__ = [
    "BusyError",
    "ClosingError",
    "ConflictError",
    "InvalidValueError",
    "LeaseError",
    "NotFoundError",
    "StorageError",
]


class NotFoundError(LookupError):
    """There is no such thing.

    Args:
        what: kind of thing, for example `rig`.
        name: what was asked for.
        remedy: where those that exist are listed.
    """

    def __init__(self, what: str, name: str, remedy: str) -> None:
        super().__init__(f"there is no {what} {name!r}")
        self.what = what
        self.name = name
        self.remedy = remedy


class ConflictError(RuntimeError):
    """Not possible in the present state.

    Args:
        message: what stands in the way.
        remedy: what to do about it.
    """

    def __init__(self, message: str, remedy: str) -> None:
        super().__init__(message)
        self.remedy = remedy


class LeaseError(ConflictError):
    """The rig is held by somebody else, or by nobody."""


class BusyError(ConflictError):
    """The rig is at work already."""


class ClosingError(ConflictError):
    """The service is shutting down."""


class InvalidValueError(ValueError):
    """A value that the caller gave is not allowed.

    Args:
        message: why, and what is allowed.
        field: where the value stood.
        value: the value.
        remedy: what to do about it.
    """

    def __init__(self, message: str, *, field: str, value: object, remedy: str) -> None:
        super().__init__(message)
        self.field = field
        self.value = value
        self.remedy = remedy
