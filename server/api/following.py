"""Lets an asyncio task follow a fan-out: the publisher's thread wakes it, it takes what waits."""

import asyncio
import contextlib
from collections.abc import AsyncIterator, Callable
from typing import TypeVar

from server.services.rigs.fanout import Fanout, Taken, count_one

T = TypeVar("T")


async def follow(
    source: Fanout[T], max_items: int, idle_s: float, weigh: Callable[[T], int] = count_one
) -> AsyncIterator[Taken[T]]:
    """Give what is published from now on, until the source is closed.

    The first comes at once, when the subscription stands, and is mostly empty; then at least every `idle_s` one does.
    `weigh` tells what a dropped item counts.
    """
    loop, news = asyncio.get_running_loop(), asyncio.Event()

    def wake() -> None:
        loop.call_soon_threadsafe(news.set)

    with source.subscribe(max_items, wake, weigh) as subscription:
        taken = subscription.take()
        yield taken
        while not taken.closed:
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(idle_s):
                    await news.wait()
            news.clear()
            taken = subscription.take()
            yield taken
