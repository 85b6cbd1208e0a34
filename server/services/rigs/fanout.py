"""Hands what a rig delivers (blocks of samples, events) to many readers, each behind a bounded queue of its own.

Theory of operation. The rig's data task calls `Fanout.publish` and never waits: each subscription has its own bounded
queue, and one that is full loses its *oldest* items and counts them (`Subscription.take` tells how many). So a
reader that is slow, or reads nothing at all, costs itself samples and nobody else anything.

Three kinds of readers share nothing:

* The *recorder* is not here at all: the journal gets every octet in the port thread, before anything decodes it.
* *Estimators* of a session are called in the data task by the session itself (`on_blocks` of `make_recording`), or
  subscribe with a queue long enough for their own stalls.
* *Viewers* (WebSocket, event streams) subscribe with a short queue.

For viewers of a rig: `served_rig.samples.subscribe(max_items=64, wake=...)`, in a `with` block. While a rig has a
subscriber and nothing is recorded, its data task streams by itself (`worker.py`); a recording's own stream takes
over.

A thread reads by `wait` and `take`. An asyncio task passes `wake`, which is called in the publisher's thread and
must not wait: `lambda: loop.call_soon_threadsafe(event.set)`; then it calls `take` (see `server/api/following.py`).
"""

import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from types import TracebackType
from typing import Generic, TypeVar

T = TypeVar("T")


def count_one(item: object) -> int:
    """Weigh any item as one."""
    return 1


@dataclass(frozen=True, slots=True, kw_only=True)
class Taken(Generic[T]):
    """What a subscription had waiting.

    Attributes:
        items: oldest first.
        dropped: what was lost to this subscriber since it began, because it read too slowly: items, or what its
            `weigh` counts; only goes up.
        closed: nothing more will come.
    """

    items: list[T]
    dropped: int
    closed: bool


class Subscription(Generic[T]):
    """One reader's bounded queue; use it as a context manager, which unsubscribes at the end.

    Args:
        max_items: items that may wait; the oldest are dropped beyond that.
        wake: called after each new item and at the end, in the publisher's thread; must not wait.
        leave: takes the subscription off its fan-out.
        weigh: what a dropped item counts, for example its samples.
    """

    def __init__(
        self,
        max_items: int,
        wake: Callable[[], None] | None,
        leave: "Callable[[Subscription[T]], None]",
        weigh: Callable[[T], int],
    ) -> None:
        self._items: deque[T] = deque(maxlen=max_items)
        self._wake = wake
        self._leave = leave
        self._weigh = weigh
        self._changed = threading.Condition()
        self._dropped = 0
        self._closed = False

    def __enter__(self) -> "Subscription[T]":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._leave(self)

    def put(self, item: T) -> None:
        """Append an item; never waits. Called by the fan-out."""
        with self._changed:
            if len(self._items) == self._items.maxlen:
                self._dropped += self._weigh(self._items[0])
            self._items.append(item)
            self._changed.notify_all()
        if self._wake is not None:
            self._wake()

    def close(self) -> None:
        """Tell the reader that nothing more will come; what waits can still be taken."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()
        if self._wake is not None:
            self._wake()

    def wait(self, timeout_s: float) -> None:
        """Wait until there is something to take or the time is over; for threads, not for asyncio tasks."""
        with self._changed:
            if not self._items and not self._closed:
                self._changed.wait(timeout_s)

    def take(self) -> Taken[T]:
        """Return all that waits, without waiting."""
        with self._changed:
            items = list(self._items)
            self._items.clear()
            return Taken(items=items, dropped=self._dropped, closed=self._closed)


class Fanout(Generic[T]):
    """All subscriptions to one source."""

    def __init__(self) -> None:
        self._subscriptions: tuple[Subscription[T], ...] = ()
        self._lock = threading.Lock()
        self._closed = False

    def subscribe(
        self,
        max_items: int,
        wake: Callable[[], None] | None = None,
        weigh: Callable[[T], int] = count_one,
    ) -> Subscription[T]:
        """Begin to receive what is published from now on.

        Args:
            max_items: items that may wait; beyond that the oldest are dropped and counted.
            wake: see `Subscription`.
            weigh: what a dropped item counts; by default one.
        """
        subscription = Subscription[T](max_items, wake, self._remove, weigh)
        with self._lock:
            closed = self._closed
            if not closed:
                self._subscriptions = (*self._subscriptions, subscription)
        if closed:
            subscription.close()
        return subscription

    @property
    def subscribers(self) -> int:
        """How many read."""
        return len(self._subscriptions)

    def publish(self, item: T) -> None:
        """Give an item to every subscriber; never waits."""
        for subscription in self._subscriptions:
            subscription.put(item)

    def close(self) -> None:
        """Tell all subscribers, and any to come, that nothing more comes."""
        with self._lock:
            self._closed = True
            subscriptions = self._subscriptions
        for subscription in subscriptions:
            subscription.close()

    def _remove(self, subscription: Subscription[T]) -> None:
        with self._lock:
            self._subscriptions = tuple(each for each in self._subscriptions if each is not subscription)
