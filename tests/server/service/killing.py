"""Kill a service with -9 in the middle of a campaign, start it again, and look whether everything is in order."""

import signal
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import httpx
import sqlalchemy as sa

from daq.recording.journal_reader import read_journal
from daq.recording.store import read_recording
from server.storage.engines import make_engine
from tests.server.service.conftest import RIG, Service

UNDER_WAY = ("starting", "running", "pausing", "paused", "stopping", "aborting")
CAMPAIGN = """name: victim
steps:
  - record:
      name: one
      duration_s: 3
      excitation: {kind: sine, amplitude_A: 0.5, period_s: 3, ramp_s: 0.5}
  - record:
      name: two
      duration_s: 3
      excitation: {kind: multisine, amplitude_A: 0.6, period_s: 3, lines: 5, seed: 3, ramp_s: 0.5}
  - identify: {train: one, test: two, sample_time_s: 0.1}
  - record:
      name: three
      duration_s: 3
      excitation: {kind: sine, amplitude_A: 0.4, period_s: 2, ramp_s: 0.5}
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Aftermath:
    """What a restart found.

    Attributes:
        state: of the campaign before and after, as the database and the service have it.
        faults: what is not in order; empty when all is.
        recovered: journals that were left open and became recordings.
    """

    state: tuple[str, str]
    faults: tuple[str, ...]
    recovered: int


def submit(client: httpx.Client) -> str:
    """Queue the campaign and return its id."""
    answer = client.post(
        "/api/v1/campaigns",
        params={"rig": RIG},
        content=CAMPAIGN,
        headers={"content-type": "application/yaml"},
    )
    assert answer.status_code == 201, answer.text
    return str(answer.json()["id"])


def kill_and_restart(
    service: Service, campaign: str, again: Callable[[], Service]
) -> tuple[Service, Aftermath]:
    """Kill the service now, start another one on the same folder, and judge what it made of it."""
    service.stop(signal.SIGKILL)
    before = _stored_state(service.database, campaign)
    journals = {path: _samples(path) for path in service.data.rglob("*.journal")}
    second = again()
    client = second.client()
    view = client.get(f"/api/v1/campaigns/{campaign}").json()
    rig = client.get(f"/api/v1/rigs/{RIG}").json()
    faults = [*_judge_state(before, view), *_judge_recordings(second, journals)]
    if rig["armed"] or rig["lease"] is not None or rig["busy_with"] is not None:
        faults.append(f"the rig is not at rest: {rig}")
    with_samples = sum(1 for count in journals.values() if count)
    state = (before, str(view["state"]))
    return second, Aftermath(state=state, faults=tuple(faults), recovered=with_samples)


def _judge_state(before: str, view: dict[str, object]) -> list[str]:
    expected = "interrupted" if before in UNDER_WAY else before
    faults = [] if view["state"] == expected else [f"{before} became {view['state']}, not {expected}"]
    if expected == "interrupted" and "the service ended" not in str(view["reason"]):
        faults.append(f"the reason is missing: {view['reason']!r}")
    items = view["items"]
    assert isinstance(items, list)
    wrong = UNDER_WAY if expected in ("queued", "done") else (*UNDER_WAY, "queued")
    faults += [f"item {item['position']} is {item['state']}" for item in items if item["state"] in wrong]
    return faults


def _judge_recordings(service: Service, journals: dict[Path, int]) -> list[str]:
    """Every sample that a journal held must be in a recording that the database lists."""
    data = service.data
    paths = _query(service.database, "select path from recordings where deleted_at is null")
    listed = {data / path for path in paths}
    faults = [f"{path.name} was left open" for path in data.rglob("*.journal")]
    faults += [f"{path} is half written" for path in data.rglob("*.partial")]
    for journal, samples in journals.items():
        recording = journal.with_name(journal.name.replace(".journal", ".parquet"))
        if samples and not recording.exists():
            faults.append(f"{recording.name} is missing")
        elif samples and read_recording(recording).n != samples:
            faults.append(f"{recording.name} has {read_recording(recording).n} of {samples} samples")
    whole = set(data.glob("campaigns/*/run-*/records/*.parquet"))
    faults += [f"{path.name} is not listed" for path in whole - listed]
    return faults


def _samples(journal: Path) -> int:
    return sum(len(block.ticks) for block in read_journal(journal).blocks)


def _stored_state(database: str, campaign: str) -> str:
    return _query(database, "select state from campaigns where id = :id", id=campaign)[0]


def _query(database: str, sql: str, **values: str) -> list[str]:
    engine = make_engine(database)
    try:
        with engine.connect() as connection:
            return list(connection.execute(sa.text(sql), values).scalars())
    finally:
        engine.dispose()
