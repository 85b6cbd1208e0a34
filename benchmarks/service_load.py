"""Eight emulated rigs at 2.5 kHz with fifty viewers, five of which read slowly or not at all.

    python -m benchmarks.service_load [--minutes 2] [--rigs 8] [--viewers 50] [--slow 5]

Everything runs on this machine: the service, an emulated controller for each rig, a process with the viewers, and this
one, which asks for lists and states all the time. Printed: samples lost on the lines and by viewers that read, how
the service's memory grows, the CPU it takes, and how long the reads last.
"""

import argparse
import asyncio
import json
import multiprocessing
import sys
import time
from collections import Counter
from dataclasses import dataclass
from multiprocessing.connection import Connection

import httpx
import numpy as np
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed

from benchmarks.service_process import BenchService, running_service
from server.services.viewing.frame import decode_live

_SETTLE_S = 20.0
_MEMORY_EVERY_S = 1.0
_PAUSE_S = 0.05
PATHS = ("/api/v1/rigs", "/api/v1/rigs/{rig}", "/api/v1/rigs/{rig}/link", "/api/v1/events?limit=100")
QUERIES = ("?interval_ms=50", "?rate_hz=250&interval_ms=50", "?interval_ms=33&columns=current_A,speed_rad_s")


@dataclass(frozen=True, slots=True)
class Viewers:
    """What the viewers' process is to do: where to look, how many, and how many of them badly."""

    urls: tuple[str, ...]
    token: str
    slow: int


async def view(url: str, token: str, pause_s: float, seen: Counter[str]) -> None:
    """Read frames, with a pause after each; count what was lost, and the disconnections."""
    kind = "slow" if pause_s else "reading"
    while True:
        try:
            headers = {"Authorization": f"Bearer {token}"}
            # A queue of one message: who does not read must not read ahead either.
            async with connect(
                url, additional_headers=headers, compression=None, max_queue=1, ping_interval=None
            ) as socket:
                dropped = lost = 0
                async for message in socket:
                    if isinstance(message, bytes):
                        frame = decode_live(message)
                        seen[f"{kind}_frames"] += 1
                        seen[f"{kind}_dropped"] += frame.dropped - dropped
                        seen[f"{kind}_lost"] += frame.lost - lost
                        dropped, lost = frame.dropped, frame.lost
                    if pause_s:
                        await asyncio.sleep(pause_s)
        except (ConnectionClosed, OSError):
            seen[f"{kind}_disconnected"] += 1
            await asyncio.sleep(1.0)


def run_viewers(plan: Viewers, pipe: Connection) -> None:
    """Let all viewers watch until the pipe says stop; send what they saw."""

    async def watch_all() -> Counter[str]:
        seen: Counter[str] = Counter()
        # Of the slow ones every other reads nothing at all, the rest a frame a second.
        pauses = [0.0 if i >= plan.slow else 1e6 if i % 2 else 1.0 for i in range(len(plan.urls))]
        tasks = [
            asyncio.create_task(view(url, plan.token, pause_s, seen))
            for url, pause_s in zip(plan.urls, pauses, strict=True)
        ]
        while not pipe.poll():
            await asyncio.sleep(0.2)
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        return seen

    pipe.send(dict(asyncio.run(watch_all())))


def read_all_the_time(service: BenchService, seconds: float) -> tuple[dict[str, list[float]], list[float]]:
    """Return how long each read lasted by path, s, and the service's memory once a second, octets."""
    durations: dict[str, list[float]] = {path: [] for path in PATHS}
    memory: list[float] = []
    end_s = time.monotonic() + seconds
    next_memory_s = time.monotonic()
    with service.client() as client:
        while (now_s := time.monotonic()) < end_s:
            if now_s >= next_memory_s:
                memory.append(float(service.memory_octets()))
                next_memory_s += _MEMORY_EVERY_S
            for path in PATHS:
                rig = service.rigs[len(memory) % len(service.rigs)]
                begun_s = time.perf_counter()
                client.get(path.format(rig=rig)).raise_for_status()
                durations[path].append(time.perf_counter() - begun_s)
            time.sleep(_PAUSE_S)
    return durations, memory


def link_totals(client: httpx.Client, rigs: tuple[str, ...]) -> Counter[str]:
    """Return what was lost on the way from the controllers, all rigs together."""
    total: Counter[str] = Counter()
    for rig in rigs:
        link = client.get(f"/api/v1/rigs/{rig}/link").json()
        for name in ("samples_lost", "queue_dropped_frames", "bad_frames", "controller_tx_drops"):
            total[name] += link[name]
        total["worst_stall_ms"] = max(total["worst_stall_ms"], round(1e3 * link["stall_s"]))
    return total


def measure(service: BenchService, viewers: int, slow: int, seconds: float) -> dict[str, object]:
    """Run viewers and reads side by side and return the figures."""
    base = service.url.replace("http", "ws")
    urls = tuple(
        f"{base}/api/v1/rigs/{service.rigs[i % len(service.rigs)]}/live{QUERIES[i % len(QUERIES)]}"
        for i in range(viewers)
    )
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    plan = Viewers(urls=urls, token=service.token, slow=slow)
    process = context.Process(target=run_viewers, args=(plan, theirs))
    process.start()
    time.sleep(_SETTLE_S)
    with service.client() as client:
        before, cpu_s, begun_s = link_totals(client, service.rigs), service.cpu_s(), time.monotonic()
        durations, memory = read_all_the_time(service, seconds)
        after, elapsed_s = link_totals(client, service.rigs), time.monotonic() - begun_s
        cpu = (service.cpu_s() - cpu_s) / elapsed_s
    ours.send("stop")
    seen = ours.recv()
    process.join()
    return {
        "seconds": round(elapsed_s, 1),
        "links": {name: after[name] - before[name] for name in after if name != "worst_stall_ms"},
        "samples_expected": round(2500 * elapsed_s * len(service.rigs)),
        "viewers": seen,
        "service_cpu_share_of_a_core": round(cpu, 3),
        "memory_mib_each_minute": [round(each / 2**20, 1) for each in memory[:: round(60 / _MEMORY_EVERY_S)]],
        "memory_slope_mib_per_min": {
            "all": slope(memory),
            "last two thirds": slope(memory[len(memory) // 3 :]),
        },
        "reads_ms": {path: percentiles(each) for path, each in durations.items()},
    }


def slope(memory: list[float]) -> float:
    """Return how fast the memory grows, MiB a minute, by a straight line through all of it."""
    minutes = np.arange(len(memory)) * _MEMORY_EVERY_S / 60.0
    return round(float(np.polyfit(minutes, np.array(memory) / 2**20, 1)[0]), 3)


def percentiles(durations: list[float]) -> dict[str, float]:
    """Return p50, p99 and worst in ms."""
    p50, p99, worst = np.percentile(np.array(durations) * 1e3, (50, 99, 100))
    return {"p50": round(float(p50), 1), "p99": round(float(p99), 1), "worst": round(float(worst), 1)}


def main() -> None:
    """Measure once and print the figures as JSON."""
    parser = argparse.ArgumentParser(description="Load of the service")
    parser.add_argument("--minutes", type=float, default=2.0)
    parser.add_argument("--rigs", type=int, default=8)
    parser.add_argument("--viewers", type=int, default=50)
    parser.add_argument("--slow", type=int, default=5)
    given = parser.parse_args()
    with running_service([f"rig{number}" for number in range(given.rigs)]) as service:
        figures = measure(service, given.viewers, given.slow, 60.0 * given.minutes)
    json.dump(figures, sys.stdout, indent=2)
    print()


if __name__ == "__main__":
    main()
