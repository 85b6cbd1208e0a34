"""The asynchronous client: the same as the other one, and against the same service."""

import asyncio
import inspect
from collections.abc import Coroutine
from pathlib import Path
from typing import TypeVar

import numpy as np
import pytest

from jointscope_client import async_job_resources, async_resources, job_resources, resources
from jointscope_client.async_client import AsyncClient
from jointscope_client.async_lease import AsyncLease
from jointscope_client.client import Client
from jointscope_client.emulated_service import EmulatedRig
from jointscope_client.errors import LeaseLostError, NotDoneError, NotFoundError
from jointscope_client.lease import Lease
from tests.server.service.measured import MODEL, measured_columns

T = TypeVar("T")
TWINS = [
    (Client, AsyncClient),
    (Lease, AsyncLease),
    *(
        (getattr(resources, name), getattr(async_resources, name))
        for name in ("Rigs", "Recordings", "Models")
    ),
    *(
        (getattr(job_resources, name), getattr(async_job_resources, name))
        for name in ("Discrepancies", "Jobs")
    ),
]


def run(coroutine: Coroutine[None, None, T]) -> T:
    """Run to the end, in a loop of its own."""
    return asyncio.run(coroutine)


def methods(kind: type) -> dict[str, list[str]]:
    """Return the parameters of each public method."""
    found = inspect.getmembers(kind, inspect.isfunction)
    return {
        name: list(inspect.signature(each).parameters) for name, each in found if not name.startswith("_")
    }


@pytest.mark.parametrize(("plain", "asynchronous"), TWINS)
def test_both_clients_have_the_same_methods(plain: type, asynchronous: type) -> None:
    assert methods(plain) == methods(asynchronous)
    assert methods(plain)


def test_recordings_models_and_analyses(
    emulated_rig: EmulatedRig, measured_file: Path, tmp_path: Path
) -> None:
    async def use() -> None:
        async with AsyncClient(emulated_rig.url, emulated_rig.token) as client:
            made = [await client.recordings.upload(measured_file, name=f"aio {k}") for k in range(3)]
            listed = [each.id async for each in client.recordings.all(text="aio", limit=2)]
            assert listed == [each.id for each in reversed(made)]
            samples = await client.recordings.samples(made[0].id, every=2)
            assert np.array_equal(samples["current_A"], measured_columns()["current_A"][::2])
            path = await client.recordings.download(made[0].id, tmp_path / "a.parquet", "stored")
            assert path.stat().st_size == made[0].size_octets
            with pytest.raises(NotFoundError):
                await client.recordings.get("nobody")
            model = await client.models.add(MODEL)
            analysis = await client.discrepancies.start(model.id, [made[0].id], [made[1].id])
            with pytest.raises(NotDoneError, match="same recording"):
                await client.discrepancies.wait(analysis.id)

    run(use())


def test_a_lease_is_renewed_and_its_loss_is_told(emulated_rig: EmulatedRig) -> None:
    async def use() -> None:
        async with AsyncClient(emulated_rig.url, emulated_rig.token) as client:
            async with client.lease(emulated_rig.id, ttl_s=1.0) as lease:
                await asyncio.sleep(1.5)
                assert (await lease.write_parameter("current_limit_A", 1.5)).value == 1.5
                async with client.lease(emulated_rig.id, take_over=True):
                    for _ in range(100):
                        if lease.lost:
                            break
                        await asyncio.sleep(0.05)
                    with pytest.raises(LeaseLostError):
                        lease.id  # noqa: B018  # reading it is what is tested
            assert (await client.rigs.get(emulated_rig.id)).raw["lease"] is None

    run(use())


def test_events_are_followed(emulated_rig: EmulatedRig) -> None:
    async def use() -> None:
        async with AsyncClient(emulated_rig.url, emulated_rig.token) as client:
            async with client.lease(emulated_rig.id):
                pass
            events = client.events(after=0)
            async for event in events:
                if event.kind == "lease.released":
                    return

    run(use())
