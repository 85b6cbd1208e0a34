"""How old samples and live estimates are when a WebSocket client gets them: rig at 1x, client on the same machine.

    python -m benchmarks.service_latency [SECONDS]        (60 by default)

A frame's header tells when its newest sample was taken, by the driver's fit of the controller's clock; the client
looks at the same wall clock when the frame has arrived. "before the next" is the age of the newest sample known just
before the following frame comes: the oldest that a page ever shows. The first seconds do not count: the clock fit
needs some pings.

Then a session is followed for as long, at each sample time. "newest sample in it" is the age of the newest sample that
the provisional estimates have used; "newest row" that of their newest row, which a sample time makes older by itself;
"final" that of the newest row whose samples were filtered to the end.
"""

import asyncio
import sys
import time

import numpy as np
from websockets.asyncio.client import connect

from benchmarks.service_process import BenchService, running_service
from jointscope_client.async_client import AsyncClient
from server.services.viewing.frame import decode_live

_SETTLE_S = 15.0
INTERVALS_MS = (0, 50)
SAMPLE_TIMES_S = (0.004, 0.02, 0.05, 0.2)
EXCITATION = {"kind": "multisine", "amplitude_A": 0.8, "period_s": 5, "lines": 8, "seed": 7, "ramp_s": 0.5}


async def watch(service: BenchService, interval_ms: int, seconds: float) -> tuple[list[float], list[float]]:
    """Return ages on arrival and just before the next frame, s."""
    url = f"{service.url.replace('http', 'ws')}/api/v1/rigs/{service.rigs[0]}/live?interval_ms={interval_ms}"
    headers = {"Authorization": f"Bearer {service.token}"}
    arrived: list[float] = []
    shown: list[float] = []
    newest_ns = 0
    async with connect(url, additional_headers=headers, compression=None) as socket:
        begun_s = time.monotonic()
        async for message in socket:
            now_ns = time.time_ns()
            elapsed_s = time.monotonic() - begun_s - _SETTLE_S
            if elapsed_s > seconds:
                break
            if isinstance(message, str) or not (frame := decode_live(message)).newest_ns:
                continue
            if elapsed_s > 0.0:
                arrived.append((now_ns - frame.newest_ns) * 1e-9)
                if newest_ns:
                    shown.append((now_ns - newest_ns) * 1e-9)
            newest_ns = frame.newest_ns
    return arrived, shown


async def measure(service: BenchService, seconds: float) -> None:
    """Let viewers with different intervals watch at the same time, and print what they saw."""
    found = await asyncio.gather(*(watch(service, interval_ms, seconds) for interval_ms in INTERVALS_MS))
    for interval_ms, (arrived, shown) in zip(INTERVALS_MS, found, strict=True):
        for name, ages in (("on arrival", arrived), ("before the next", shown)):
            p50, p99, worst = np.percentile(np.array(ages) * 1e3, (50, 99, 100))
            print(
                f"interval_ms={interval_ms:<3} {name:16} p50 {p50:6.1f} ms, p99 {p99:6.1f} ms, worst {worst:6.1f} ms "
                f"({len(ages)} frames)"
            )


async def follow(service: BenchService, sample_time_s: float, seconds: float) -> dict[str, list[float]]:
    """Return the ages of what a session's followers are told, s."""
    ages: dict[str, list[float]] = {"newest sample in it": [], "newest row": [], "final": []}
    async with AsyncClient(service.url, service.token) as client:
        session = await client.create_session(
            rig=service.rigs[0],
            excitation=EXCITATION,
            duration_s=seconds + _SETTLE_S,
            sample_time_s=sample_time_s,
        )
        await client.sessions.command(session.id, "start")
        async for moment in client.follow_session(session.id, interval_ms=0):
            now_ns, ahead = time.time_ns(), moment.provisional_time_s
            if moment.state != "running" or not moment.newest_ns or ahead is None or ahead < _SETTLE_S:
                continue
            age_s = (now_ns - moment.newest_ns) * 1e-9
            newest_s = moment.raw["live"]["provisional"]["newest_s"]
            if newest_s < seconds + _SETTLE_S:  # what comes behind the excitation is in no row
                ages["newest sample in it"].append(age_s)
                ages["newest row"].append(age_s + newest_s - ahead)
                ages["final"].append(age_s + newest_s - moment.time_s)
    return ages


async def measure_estimates(service: BenchService, seconds: float) -> None:
    """Follow one session after the other, and print the ages."""
    for sample_time_s in SAMPLE_TIMES_S:
        before_s, begun_s = service.cpu_s(), time.monotonic()
        for name, ages in (await follow(service, sample_time_s, seconds)).items():
            p50, p99, worst = np.percentile(np.array(ages) * 1e3, (50, 99, 100))
            print(
                f"estimates each {sample_time_s * 1e3:g} ms, {name:19} p50 {p50:6.1f} ms, p99 {p99:6.1f} ms, "
                f"worst {worst:6.1f} ms ({len(ages)} messages)"
            )
        share = (service.cpu_s() - before_s) / (time.monotonic() - begun_s)
        print(f"CPU of the service {share:.1%} of a core")


def main() -> None:
    """Measure once."""
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 60.0
    with running_service(["rig"]) as service:
        before_s, begun_s = service.cpu_s(), time.monotonic()
        asyncio.run(measure(service, seconds))
        share = (service.cpu_s() - before_s) / (time.monotonic() - begun_s)
        print(f"CPU of the service {share:.1%} of a core")
        asyncio.run(measure_estimates(service, seconds))


if __name__ == "__main__":
    main()
