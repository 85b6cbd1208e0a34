"""The operator's lease of a rig: one person or script at a time moves it, and only while it says that it is there.

Theory of operation. A lease is granted for some seconds and must be renewed; when it is over, nobody holds the rig.
The driver asks `OperatorLease.is_live` before each keep-alive to the controller: without a live operator lease none
is sent, so the *drive's* own lease (some 250 ms) runs out and the controller ramps to zero and latches its safe
state by itself. No code of ours has to run for that.

Taking over is explicit: the rig is brought to rest first, under the old lease; then the old one ends, its holder is
told by an event, and the new one begins. Leases do not survive a restart of the service. Time is monotonic, s.
"""

import secrets
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum

from server.services.errors import InvalidValueError, LeaseError
from server.services.tokens import Principal

MIN_TTL_S = 1.0
MAX_TTL_S = 3600.0
_REMEDY_HELD = (
    "wait until it ends, ask its holder to release it, or take it over (the drive ramps down first)"
)


class LeaseEnd(StrEnum):
    """How a lease ended."""

    RELEASED = "released"
    EXPIRED = "expired"
    TAKEN_OVER = "taken_over"
    SHUTDOWN = "shutdown"


@dataclass(frozen=True, slots=True, kw_only=True)
class Grant:
    """A lease as it was granted or renewed.

    Attributes:
        id: the secret that each moving request shows.
        token_id: whose token took it.
        holder: name of that token.
        ttl_s: granted for so long from each renewal on.
        ends_s: monotonic time of its end.
    """

    id: str
    token_id: str
    holder: str
    ttl_s: float
    ends_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class LeaseView:
    """A live lease as everybody may see it, without its secret."""

    holder: str
    token_id: str
    expires_in_s: float


class OperatorLease:
    """The lease of one rig.

    Args:
        on_end: told of each lease that ended and how.
        clock: monotonic time, s.
    """

    def __init__(
        self, on_end: Callable[[Grant, LeaseEnd], None], clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._on_end = on_end
        self._clock = clock
        self._lock = threading.Lock()
        self._taking_over = threading.Lock()
        self._grant: Grant | None = None
        self._handing_over = False

    def is_live(self) -> bool:
        """Tell whether somebody holds the rig now; asked before each keep-alive, so it takes no lock."""
        grant = self._grant
        return grant is not None and self._clock() < grant.ends_s

    def view(self) -> LeaseView | None:
        """Return who holds the rig, None when nobody does."""
        grant = self._grant
        if grant is None or self._clock() >= grant.ends_s:
            return None
        left_s = grant.ends_s - self._clock()
        return LeaseView(holder=grant.holder, token_id=grant.token_id, expires_in_s=left_s)

    def acquire(self, who: Principal, ttl_s: float) -> Grant:
        """Take the lease.

        Raises:
            LeaseError: somebody holds it.
            InvalidValueError: `ttl_s` out of range.
        """
        _check_ttl(ttl_s)
        self.expire()
        with self._lock:
            if self._grant is not None:
                raise LeaseError(f"{self._grant.holder} holds this rig", _REMEDY_HELD)
            self._grant = self._new_grant(who, ttl_s)
            return self._grant

    def take_over(self, who: Principal, ttl_s: float, come_to_rest: Callable[[], None]) -> Grant:
        """Take the lease from whoever holds it, after the rig has come to rest.

        Args:
            who: the new holder.
            ttl_s: length of the lease.
            come_to_rest: ramps the drive down and returns when it rests.

        Raises:
            InvalidValueError: `ttl_s` out of range.
        """
        _check_ttl(ttl_s)
        with self._taking_over:
            self._handing_over = True  # the old holder may keep the ramp alive, and begin nothing new
            try:
                come_to_rest()
                with self._lock:
                    loser, self._grant = self._grant, self._new_grant(who, ttl_s)
                    grant = self._grant
            finally:
                self._handing_over = False
        if loser is not None:
            self._on_end(loser, LeaseEnd.TAKEN_OVER)
        return grant

    def renew(self, lease_id: str, ttl_s: float | None = None) -> Grant:
        """Hold on to the lease.

        Raises:
            LeaseError: it has ended, or is somebody else's.
        """
        if ttl_s is not None:
            _check_ttl(ttl_s)
        with self._lock:
            grant = self._checked(lease_id)
            ttl_s = grant.ttl_s if ttl_s is None else ttl_s
            self._grant = Grant(
                id=grant.id,
                token_id=grant.token_id,
                holder=grant.holder,
                ttl_s=ttl_s,
                ends_s=self._clock() + ttl_s,
            )
            return self._grant

    def release(self, lease_id: str, how: LeaseEnd = LeaseEnd.RELEASED) -> None:
        """Give the rig back.

        Raises:
            LeaseError: the lease has ended, or is somebody else's.
        """
        with self._lock:
            grant = self._checked(lease_id)
            self._grant = None
        self._on_end(grant, how)

    def check(self, lease_id: str) -> Grant:
        """Return the live lease with this id.

        Raises:
            LeaseError: it has ended, or is somebody else's.
        """
        with self._lock:
            if self._handing_over:
                raise LeaseError("this rig is being taken over", _REMEDY_HELD)
            return self._checked(lease_id)

    def expire(self) -> None:
        """End the lease if its time is over; called now and then, so that its end is told."""
        with self._lock:
            grant = self._grant
            if grant is None or self._clock() < grant.ends_s:
                return
            self._grant = None
        self._on_end(grant, LeaseEnd.EXPIRED)

    def _checked(self, lease_id: str) -> Grant:
        grant = self._grant
        if grant is None or self._clock() >= grant.ends_s:
            raise LeaseError("nobody holds this rig's lease any more", "take the lease, then try again")
        if not secrets.compare_digest(grant.id.encode(), lease_id.encode()):
            raise LeaseError(f"this lease has ended; {grant.holder} holds the rig", _REMEDY_HELD)
        return grant

    def _new_grant(self, who: Principal, ttl_s: float) -> Grant:
        return Grant(
            id=secrets.token_urlsafe(16),
            token_id=who.token_id,
            holder=who.name,
            ttl_s=ttl_s,
            ends_s=self._clock() + ttl_s,
        )


def _check_ttl(ttl_s: float) -> None:
    if not MIN_TTL_S <= ttl_s <= MAX_TTL_S:
        raise InvalidValueError(
            f"ttl_s={ttl_s:g} must lie in [{MIN_TTL_S:g}, {MAX_TTL_S:g}] s",
            field="ttl_s",
            value=ttl_s,
            remedy="10 s, renewed every 3 s, suits a page or a script",
        )
