"""The operator's lease of a rig as an asynchronous context manager that renews it in a task."""

import asyncio
import contextlib
from types import TracebackType
from typing import Protocol, TypeVar

from jointscope_client import calls
from jointscope_client.errors import ClientError, LeaseLostError, ProblemError
from jointscope_client.lease import RENEWALS
from jointscope_client.records import Parameter

T = TypeVar("T")


class Performer(Protocol):
    """What sends calls."""

    async def perform(self, call: calls.Call[T]) -> T:
        """Send one call."""
        ...


class AsyncLease:
    """Holds a rig from `async with` to its end.

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
        self._task: asyncio.Task[None] | None = None
        self._lost: ClientError | None = None

    async def __aenter__(self) -> "AsyncLease":
        self._id = await self._client.perform(calls.take_lease(self.rig_id, self._ttl_s, self._take_over))
        self._lost = None
        self._task = asyncio.create_task(self._renew(self._id), name=f"lease of {self.rig_id}")
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._task is not None:
            self._task.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await self._task
        lease_id, self._id = self._id, None
        if lease_id is not None and self._lost is None:
            try:
                await self._client.perform(calls.release_lease(self.rig_id, lease_id))
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
            raise ClientError(
                "this lease is not held: use it inside `async with client.lease(...) as lease:`"
            )
        return self._id

    @property
    def lost(self) -> bool:
        """Whether it ended before its time."""
        return self._lost is not None

    async def clear_fault(self) -> None:
        """Leave a latched fault, once its cause is gone. See that the rig is safe before you do."""
        path = calls.path_of("rigs", self.rig_id, "clear-fault")
        await self._client.perform(
            calls.Call(method="POST", path=path, read=calls.nothing, headers=calls.with_lease(self.id))
        )

    async def write_parameter(self, name: str, value: float) -> Parameter:
        """Write a controller parameter and return what is in force."""
        return await self._client.perform(calls.write_parameter(self.rig_id, self.id, name, value))

    async def _renew(self, lease_id: str) -> None:
        while True:
            await asyncio.sleep(self._ttl_s / RENEWALS)
            try:
                await self._client.perform(calls.renew_lease(self.rig_id, lease_id))
            except ProblemError as error:
                self._lost = error
                return
            except ClientError:  # not reached this time; the lease may live until the next
                continue
