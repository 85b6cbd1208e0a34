"""Lets an asyncio task follow a fan-out: the publisher's thread wakes it, it takes what waits."""

import asyncio
import contextlib
from collections.abc import AsyncIterator
from typing import TypeVar

from server.services.rigs.fanout import Fanout, Taken

T = TypeVar("T")


async def follow(source: Fanout[T], max_items: int, idle_s: float) -> AsyncIterator[Taken[T]]:
    """Give what is published from now on, at least every `idle_s` (then empty), until the source is closed."""
    loop, news = asyncio.get_running_loop(), asyncio.Event()

    def wake() -> None:
        loop.call_soon_threadsafe(news.set)

    with source.subscribe(max_items, wake) as subscription:
        closed = False
        while not closed:
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(news.wait(), idle_s)
            news.clear()
            taken = subscription.take()
            closed = taken.closed
            yield taken
