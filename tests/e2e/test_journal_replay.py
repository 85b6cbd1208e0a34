"""The journal against the live path: the same numbers, and nothing lost to a SIGKILL at any moment."""

import random
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from daq.driver.options import RecordPlan, RigOptions
from daq.driver.rig import open_rig
from daq.driver.session import record
from daq.excitation.check import Nameplate
from daq.excitation.spec import Sine
from daq.protocol.stream import SampleBlock
from daq.recording.header import make_header
from daq.recording.journal import Journal
from daq.recording.journal_reader import read_journal
from daq.recording.recovery import RecoveryOutcome, recover_journals
from daq.recording.store import read_recording
from tests.e2e.conftest import Emulate

pytestmark = pytest.mark.slow

KILLS = 10
PLAN = RecordPlan(
    excitation=Sine(amplitude_a=0.5, period_s=5.0),
    duration_s=20.0,
    nameplate=Nameplate(inertia_kg_m2=0.5, viscous_friction_nm_s_rad=0.9, torque_constant_nm_a=1.0),
    lease_ms=2000,
)
RECORDER = """\
import sys
import time
from dataclasses import replace
from pathlib import Path
from daq.driver.options import RigOptions
from daq.driver.rig import open_rig
from daq.driver.session import record
from daq.protocol.codes import DriveState
from daq.recording.header import make_header
from daq.recording.journal import Journal
from tests.e2e.test_journal_replay import PLAN

def tell(blocks):
    for block in blocks:
        if block.ticks.size:
            print(int(block.ticks[-1]), flush=True)

with open_rig(sys.argv[1], RigOptions(start_baud=int(sys.argv[3]))) as rig:
    rig.disarm()  # the one who was killed has left the drive on, or in its safe state by now
    before, deadline_s = rig.status, time.monotonic() + 30.0
    while rig.status is before or rig.status.state in (DriveState.ARMED, DriveState.RUNNING, DriveState.RAMPING):
        if time.monotonic() > deadline_s:
            raise SystemExit("the drive does not come to rest")
        rig.next_blocks(0.05)
    rig.clear_fault()
    header = make_header(dictionary=rig.dictionary_octets, tick_hz=rig.hello.tick_hz, divisor=1, details={})
    record(rig, replace(PLAN, duration_s=1e4), Journal.create(Path(sys.argv[2]), header), on_blocks=tell)
"""


@pytest.mark.parametrize("scenario", ["nominal", "noisy_link", "unplugged"])
def test_a_replay_is_what_was_seen_live_number_for_number(
    scenario: str, emulate: Emulate, tmp_path: Path
) -> None:
    (tmp_path / "unplugged.yaml").write_text(
        "name: unplugged\nfaults:\n  - {name: disconnect, at_s: 12, duration_s: 0.2}\n"
    )
    live: list[SampleBlock] = []
    path = tmp_path / "a.journal"
    with open_rig(str(emulate(scenario, "max")), RigOptions()) as rig:
        header = make_header(
            dictionary=rig.dictionary_octets, tick_hz=rig.hello.tick_hz, divisor=1, details={}
        )
        journal = Journal.create(path, header)
        outcome = record(rig, PLAN, journal, on_blocks=live.extend)
        journal.close(outcome.end.value)
    replayed = read_journal(path).blocks
    assert outcome.samples_expected > 20 * 2500
    assert [gap for block in replayed for gap in block.gaps] == [gap for block in live for gap in block.gaps]
    assert {gap.cause.value for block in live for gap in block.gaps} == {
        "nominal": set(),
        "noisy_link": {"loss"},
        "unplugged": {"reconnect"},
    }[scenario]
    np.testing.assert_array_equal(joined(replayed, "ticks"), joined(live, "ticks"))
    for channel in ("current_ref", "current", "position"):
        np.testing.assert_array_equal(joined(replayed, channel), joined(live, channel))


def test_nothing_received_is_lost_to_a_kill_at_any_moment(emulate: Emulate, tmp_path: Path) -> None:
    moments, port = random.Random(20), str(emulate("nominal", "max"))
    for number in range(KILLS):
        folder = tmp_path / f"{number}"
        folder.mkdir()
        left_at = 937_500 if number else 115_200
        command = [sys.executable, "-c", RECORDER, port, str(folder / "a.journal"), str(left_at)]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        assert process.stdout is not None
        lines = [process.stdout.readline() for _ in range(moments.randrange(1, 150))]
        process.kill()
        rest, _ = process.communicate()
        seen_tick = max(
            int(line) for line in (*lines, *rest.splitlines(keepends=True)) if line.endswith("\n")
        )
        (report,) = recover_journals(folder)
        assert report.outcome is RecoveryOutcome.RECOVERED
        assert report.recording is not None
        recording = read_recording(report.recording)
        assert recording.gaps == ()
        assert recording.metadata["ended"] == {"closed": False, "reason": "left open"}
        last_tick = recording.metadata["first_tick"] + recording.n - 1
        assert last_tick >= seen_tick


def joined(blocks: Sequence[SampleBlock], name: str) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    """Return the ticks or a channel of all blocks as one array."""
    parts = [block.ticks if name == "ticks" else block.counts[name] for block in blocks if block.ticks.size]
    return np.concatenate(parts).astype(np.int64)
