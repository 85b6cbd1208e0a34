"""The operator's lease and the drive's: no live operator lease, no keep-alive, and the drive stops by itself."""

import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from daq.driver.options import RecordPlan
from daq.driver.outcome import RecordEnd, RecordOutcome
from daq.driver.rig import Rig as DriverRig
from daq.driver.session import record
from daq.excitation.check import Nameplate
from daq.excitation.spec import Sine
from server.services.container import Services, open_services
from server.services.errors import BusyError, LeaseError
from server.services.rigs.served_rig import ServedRig
from server.services.rigs.worker import RigJob
from server.services.settings import ServiceSettings
from server.services.tokens import Principal, Scope
from tests.server.service.conftest import CONFIG, RIG

JOINT = Nameplate(inertia_kg_m2=0.5, viscous_friction_nm_s_rad=0.9, torque_constant_nm_a=1.0)
ALICE = Principal(token_id="a", name="alice", scopes=frozenset(Scope))
BOB = Principal(token_id="b", name="bob", scopes=frozenset(Scope))


class Sink:
    """Keeps nothing."""

    def append(self, raw: bytes) -> None:
        """Forget it."""

    def note(self, kind: str, data: object) -> None:
        """Forget it."""


@pytest.fixture
def services(tmp_path: Path) -> Iterator[Services]:
    settings = ServiceSettings(
        data_dir=tmp_path,
        rigs_dir=CONFIG / "rigs",
        emulate=CONFIG / "scenarios" / "nominal.yaml",
        speed="1",
    )
    opened = open_services(settings)
    yield opened
    opened.close()


@pytest.fixture
def rig(services: Services) -> ServedRig:
    served = services.rigs.get(RIG)
    served.connect()
    return served


def long_run(rig: ServedRig, begun: threading.Event) -> RigJob[RecordOutcome]:
    """Return work that plays a sine until somebody ends it."""
    stop = threading.Event()
    plan = RecordPlan(
        excitation=Sine(amplitude_a=0.3, period_s=5.0), duration_s=1e4, nameplate=JOINT, lease_ms=500
    )

    def run(driver: DriverRig) -> RecordOutcome:
        return record(driver, plan, Sink(), lambda _: begun.set(), rig.worker.publish, stop)

    return RigJob(title="a long run", run=run, stop=stop)


def test_a_lease_that_runs_out_stops_the_drive_by_its_own_lease(rig: ServedRig) -> None:
    grant, begun = rig.acquire(ALICE, 60.0), threading.Event()
    future = rig.perform(long_run(rig, begun), grant.id)
    assert begun.wait(30)
    rig.lease.renew(grant.id, 1.0)
    outcome = future.result(timeout=60)
    assert outcome.end is RecordEnd.TRIPPED
    assert "the drive's lease ran out" in outcome.text
    for _ in range(200):  # the controller tells its state ten times a second
        drive = rig.view().drive
        if drive is not None and drive.state == "safe_timeout":
            return
        time.sleep(0.02)
    pytest.fail(f"the drive is not in its safe state: {drive}")


def test_a_lease_that_is_renewed_keeps_the_drive_running(rig: ServedRig) -> None:
    grant, begun = rig.acquire(ALICE, 60.0), threading.Event()
    job = long_run(rig, begun)
    future = rig.perform(job, grant.id)
    assert begun.wait(30)
    for _ in range(10):  # together longer than the lease
        rig.lease.renew(grant.id, 2.0)
        assert not job.stop.wait(0.25)
    assert not future.done()
    job.stop.set()
    assert future.result(timeout=30).end is RecordEnd.STOPPED


def test_taking_over_ramps_down_first_and_the_old_lease_is_worth_nothing(rig: ServedRig) -> None:
    old, begun = rig.acquire(ALICE, 60.0), threading.Event()
    future = rig.perform(long_run(rig, begun), old.id)
    assert begun.wait(30)
    rig.take_over(BOB, 60.0)
    assert future.result(timeout=1).end is RecordEnd.STOPPED
    assert not rig.view().armed
    with pytest.raises(LeaseError, match="bob holds the rig"):
        rig.perform(long_run(rig, begun), old.id)


def test_a_rig_at_work_takes_no_other_work(rig: ServedRig) -> None:
    grant, begun = rig.acquire(ALICE, 60.0), threading.Event()
    job = long_run(rig, begun)
    future = rig.perform(job, grant.id)
    with pytest.raises(BusyError, match="busy with a long run"):
        rig.perform(long_run(rig, begun), grant.id)
    job.stop.set()
    future.result(timeout=30)


def test_viewers_get_samples_of_an_idle_rig_and_cost_nothing_when_gone(rig: ServedRig) -> None:
    with rig.samples.subscribe(max_items=64) as viewer:
        viewer.wait(10.0)
        taken = viewer.take()
    assert taken.items
    assert taken.items[0].ticks.size
    assert rig.samples.subscribers == 0


def test_a_viewer_that_never_reads_loses_samples_and_the_run_none(rig: ServedRig) -> None:
    grant, begun = rig.acquire(ALICE, 60.0), threading.Event()
    job = long_run(rig, begun)
    with rig.samples.subscribe(max_items=2) as sleeper:
        future = rig.perform(job, grant.id)
        assert begun.wait(30)
        assert not job.stop.wait(1.0)
        job.stop.set()
        outcome = future.result(timeout=30)
        assert sleeper.take().dropped > 0
    assert outcome.samples_lost == 0


def test_closing_the_services_brings_a_running_rig_to_rest(services: Services, rig: ServedRig) -> None:
    grant, begun = rig.acquire(ALICE, 60.0), threading.Event()
    future = rig.perform(long_run(rig, begun), grant.id)
    assert begun.wait(30)
    services.rigs.close()
    assert future.result(timeout=1).end is RecordEnd.STOPPED
    assert rig.view().connection == "disconnected"
