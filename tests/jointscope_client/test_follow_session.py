"""A session followed live by both clients, against the real service and the emulated controller."""

import asyncio
from collections.abc import Callable

import numpy as np
import pytest

from jointscope_client.async_client import AsyncClient
from jointscope_client.client import Client
from jointscope_client.emulated_service import EmulatedRig
from jointscope_client.errors import AccessError, NotFoundError
from jointscope_client.session_live import SessionMoment

DURATION_S = 30
EXCITATION = {"kind": "multisine", "amplitude_A": 0.8, "period_s": 5, "lines": 8, "seed": 7, "ramp_s": 0.5}


@pytest.fixture(scope="module")
def moments(emulated_rigs: Callable[[], EmulatedRig]) -> list[SessionMoment]:
    """All that is told of a session, followed from before its start."""
    rig = emulated_rigs()
    rig.rest()
    client, moments = rig.client, list[SessionMoment]()
    session = client.create_session(
        rig=rig.id, excitation=EXCITATION, duration_s=DURATION_S, sample_time_s=0.05
    )
    for moment in client.follow_session(session.id, interval_ms=0):
        if not moments:
            client.sessions.command(session.id, "start")
        moments.append(moment)
    return moments


def test_a_session_is_followed_from_before_its_start_to_its_end(moments: list[SessionMoment]) -> None:
    assert (moments[0].state, moments[-1].state) == ("created", "done")
    assert [each.raw["number"] for each in moments] == list(range(len(moments)))
    received = [each.samples_received for each in moments]
    assert received == sorted(received)
    assert moments[-1].samples_lost == 0


def test_estimates_come_with_standard_errors_and_the_last_are_those_of_the_session(
    emulated_rig: EmulatedRig, moments: list[SessionMoment]
) -> None:
    last = moments[-1]
    rls = last.estimates["rls"]
    assert rls.names == ("a1", "a2", "b0", "b1")
    assert (rls.errors > 0).all()
    assert (
        last.raw["live"]["estimators"]
        == (emulated_rig.client.sessions.get(last.raw["id"]).raw["live"]["estimators"])
    )


def test_provisional_estimates_are_ahead_and_close_to_what_stands_later(
    moments: list[SessionMoment],
) -> None:
    ahead = [each for each in moments if each.provisional_time_s is not None and each.provisional_time_s > 10]
    assert ahead
    for moment in ahead:
        assert moment.provisional_time_s is not None
        assert moment.provisional_time_s > moment.time_s
        # Of the newest sample at most one sample time is not yet in a row.
        newest_s = min(DURATION_S, moment.raw["live"]["provisional"]["newest_s"])
        assert newest_s - moment.provisional_time_s < 0.05 + 1e-9
        now = moment.provisional["rls"]
        later = next(
            each.estimates["rls"] for each in moments if each.time_s >= moment.provisional_time_s - 1e-9
        )
        assert np.all(np.abs(now.values - later.values) < 3 * now.errors)


def test_who_may_not_or_asks_for_nobody_is_refused(emulated_rig: EmulatedRig) -> None:
    with pytest.raises(NotFoundError):
        next(emulated_rig.client.follow_session("nobody"))
    with Client(emulated_rig.url, "js_wrong") as stranger, pytest.raises(AccessError):
        next(stranger.follow_session("nobody"))


def test_the_asynchronous_client_is_given_the_end_of_a_session_that_is_over(
    emulated_rig: EmulatedRig, moments: list[SessionMoment]
) -> None:
    async def use() -> list[SessionMoment]:
        async with AsyncClient(emulated_rig.url, emulated_rig.token) as client:
            return [each async for each in client.follow_session(moments[-1].raw["id"])]

    found = asyncio.run(use())
    assert [each.state for each in found] == ["done"]
    assert found[0].raw["live"] == moments[-1].raw["live"]
