"""The operator's lease as a job holds it: taken as the submitter, renewed by a thread, and watched for its loss."""

import threading
from collections.abc import Callable
from types import TracebackType

from server.services.errors import BusyError, ConflictError, LeaseError
from server.services.rigs.served_rig import ServedRig
from server.services.tokens import Principal

TTL_S = 6.0
_RENEW_S = 1.0
_TELL_WHO_S = 3.0


class HeldLease:
    """A context manager that holds a rig for a job.

    Args:
        rig: the rig.
        who: who submitted the job.
        on_lost: told once, with the reason, when the lease is gone; called by the renewing thread.
    """

    def __init__(self, rig: ServedRig, who: Principal, on_lost: Callable[[str], None]) -> None:
        self._rig = rig
        self._who = who
        self._on_lost = on_lost
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._renew, name=f"jointscope-lease-{rig.id}", daemon=True)
        self.id = ""

    def __enter__(self) -> "HeldLease":
        self.id = take_lease(self._rig, self._who)
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._over.set()
        self._thread.join()
        try:
            self._rig.release(self.id)
        except ConflictError:  # lost already, or it does not come to rest: then the lease runs out by itself
            return

    def why_lost(self) -> str | None:
        """Return who has the rig now, or is about to; None while the lease is ours."""
        try:
            self._rig.lease.check(self.id)
        except LeaseError as error:
            return self._explain(error)
        return None

    def _renew(self) -> None:
        while not self._over.wait(_RENEW_S):
            try:
                self._rig.lease.renew(self.id)
            except LeaseError as error:
                self._on_lost(self._explain(error))
                return

    def _explain(self, error: LeaseError) -> str:
        """Say who took the lease; while it is being taken over that is not known at once."""
        for _ in range(int(_TELL_WHO_S / 0.05)):
            try:
                self._rig.lease.renew(self.id)
            except LeaseError:
                break
            self._over.wait(0.05)
        view = self._rig.lease.view()
        if view is None:
            return f"the operator's lease was lost: {error}"
        return f"{view.holder} took over the rig; the drive came to rest first"


def take_lease(rig: ServedRig, who: Principal) -> str:
    """Take a rig's lease for a job; one that the same token holds by hand passes to the job.

    Raises:
        BusyError: the rig is at work.
        LeaseError: somebody else holds it.
    """
    check_free(rig, who)
    if rig.lease.view() is None:
        return rig.acquire(who, TTL_S).id
    return rig.take_over(who, TTL_S).id


def check_free(rig: ServedRig, who: Principal) -> None:
    """Refuse a rig that is at work, or held by another token.

    Raises:
        BusyError: the rig is at work.
        LeaseError: somebody else holds it.
    """
    busy, view = rig.worker.busy_with, rig.lease.view()
    if busy is not None:
        raise BusyError(f"rig {rig.id} is busy with {busy}", "wait for its end, or stop it")
    if view is not None and view.token_id != who.token_id:
        raise LeaseError(f"{view.holder} holds this rig", "wait until the lease ends, or take it over")
