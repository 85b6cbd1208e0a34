"""The operator's lease of a rig as a context manager that renews it in a thread."""

import threading
from types import TracebackType
from typing import Protocol, TypeVar

from jointscope_client import calls
from jointscope_client.errors import ClientError, LeaseLostError, ProblemError
from jointscope_client.records import Parameter

T = TypeVar("T")
RENEWALS = 3.0
"""So many in the time that the lease lives without."""


class Performer(Protocol):
    """What sends calls."""

    def perform(self, call: calls.Call[T]) -> T:
        """Send one call."""
        ...


class Lease:
    """Holds a rig from `with` to its end.

    Args:
        client: what sends calls.
        rig_id: the rig.
        ttl_s: without renewal, the lease ends after so long.
        take_over: take it from its holder.
    """

    def __init__(self, client: Performer, rig_id: str, ttl_s: float, take_over: bool) -> None:
        self._client = client
        self.rig_id = rig_id
        self._ttl_s, self._take_over = ttl_s, take_over
        self._id: str | None = None
        self._done = threading.Event()
        self._thread: threading.Thread | None = None
        self._lost: ClientError | None = None

    def __enter__(self) -> "Lease":
        self._id = self._client.perform(calls.take_lease(self.rig_id, self._ttl_s, self._take_over))
        self._done.clear()
        self._lost = None
        self._thread = threading.Thread(target=self._renew, name=f"lease of {self.rig_id}", daemon=True)
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._done.set()
        if self._thread is not None:
            self._thread.join()
        lease_id, self._id = self._id, None
        if lease_id is not None and self._lost is None:
            try:
                self._client.perform(calls.release_lease(self.rig_id, lease_id))
            except LeaseLostError:
                if kind is None:  # nobody knows yet
                    raise

    @property
    def id(self) -> str:
        """Return the lease's id, to be shown with whatever moves the rig.

        Raises:
            LeaseLostError: it was taken over, or could not be renewed in time.
            ClientError: not held.
        """
        if self._lost is not None:
            raise self._lost
        if self._id is None:
            raise ClientError("this lease is not held: use it inside `with client.lease(...) as lease:`")
        return self._id

    @property
    def lost(self) -> bool:
        """Whether it ended before its time."""
        return self._lost is not None

    def clear_fault(self) -> None:
        """Leave a latched fault, once its cause is gone. See that the rig is safe before you do."""
        path = calls.path_of("rigs", self.rig_id, "clear-fault")
        self._client.perform(
            calls.Call(method="POST", path=path, read=calls.nothing, headers=calls.with_lease(self.id))
        )

    def write_parameter(self, name: str, value: float) -> Parameter:
        """Write a controller parameter and return what is in force."""
        return self._client.perform(calls.write_parameter(self.rig_id, self.id, name, value))

    def _renew(self) -> None:
        while self._id is not None and not self._done.wait(self._ttl_s / RENEWALS):
            try:
                self._client.perform(calls.renew_lease(self.rig_id, self._id))
            except ProblemError as error:
                self._lost = error
                return
            except ClientError:  # not reached this time; the lease may live until the next
                continue
