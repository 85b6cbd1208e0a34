"""The driver against the emulated controller's process, over a pseudo-terminal."""

import threading
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from daq.driver.capture import CapturePlan, read_capture, start_capture
from daq.driver.options import RecordPlan, RigOptions, StreamPlan
from daq.driver.outcome import RecordEnd, RecordOutcome, RecordProgress
from daq.driver.preflight import bounded
from daq.driver.rig import Rig, open_rig
from daq.driver.session import record
from daq.errors import DeviceFaultError, ExcitationLimitError, JournalWriteError, PortError
from daq.excitation.check import Nameplate
from daq.excitation.spec import (
    Chirp,
    Excitation,
    Multisine,
    Prbs,
    Setpoints,
    Sine,
    Staircase,
    Table,
    Trapezoid,
)
from daq.excitation.waveform import run_length, sample_reference
from daq.protocol.codes import CURRENT_COUNT_A, ChirpMode, FaultBit, StaircaseMode, Trigger
from daq.protocol.stream import SampleBlock
from daq.protocol.tick_axis import GapCause

JOINT = Nameplate(inertia_kg_m2=0.5, viscous_friction_nm_s_rad=0.9, torque_constant_nm_a=1.0)
Emulate = Callable[[str, str], Path]


class Sink:
    """Counts octets and keeps notes; refuses more than `room` octets."""

    def __init__(self, room: float = float("inf")) -> None:
        self.room = room
        self.octets = 0
        self.notes: dict[str, Mapping[str, Any]] = {}

    def append(self, raw: bytes) -> None:
        """Count octets."""
        self.octets += len(raw)
        if self.octets > self.room:
            raise JournalWriteError("journal cannot be written: no space left on device; free some space")

    def note(self, kind: str, data: Mapping[str, Any]) -> None:  # JSON values
        """Keep the last note of each kind."""
        self.notes[kind] = data


@pytest.fixture
def rig(emulate: Emulate) -> Iterator[Rig]:
    with open_rig(str(emulate("nominal", "max")), RigOptions()) as opened:
        yield opened


def plan(
    excitation: Excitation | Setpoints, duration_s: float = 2.0, *, centring: bool = False
) -> RecordPlan:
    """Return a plan for the emulated joint."""
    return RecordPlan(
        excitation=excitation, duration_s=duration_s, nameplate=JOINT, centring=centring, lease_ms=500
    )


def play(rig: Rig, what: RecordPlan) -> tuple[RecordOutcome, np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    """Record and return the outcome, the ticks and the recorded reference in counts."""
    blocks: list[SampleBlock] = []
    outcome = record(rig, what, Sink(), on_blocks=blocks.extend)
    blocks = [block for block in blocks if block.ticks.size]
    ticks = np.concatenate([block.ticks for block in blocks])
    return outcome, ticks, np.concatenate([block.counts["current_ref"] for block in blocks])


EVERY_GENERATOR = (
    Sine(amplitude_a=0.5, offset_a=0.05, period_s=1.3, phase_turns=0.1, ramp_s=0.2),
    Trapezoid(amplitude_a=0.5, period_s=1.1, rise_fraction=0.2),
    Chirp(amplitude_a=0.4, sweep_s=1.5, start_hz=0.5, end_hz=20.0, mode=ChirpMode.LOGARITHMIC),
    Chirp(amplitude_a=0.4, sweep_s=0.5, start_hz=0.5, end_hz=20.0, repeat=True),
    Prbs(amplitude_a=0.3, register_bits=7, bit_s=0.02, seed=99),
    Staircase(amplitude_a=0.4, levels=5, level_s=0.1, mode=StaircaseMode.FROM_ZERO, repeat=True),
    Staircase(amplitude_a=0.4, levels=4, level_s=0.1, mode=StaircaseMode.UP_DOWN),
    Multisine(amplitude_a=0.6, period_s=1.0, lines=12, step=2, seed=5),
    Table(values_a=(0.1, -0.2, 0.3, 0.0), hold_s=0.02, amplitude_a=0.5, repeat=True),
)


@pytest.mark.slow
@pytest.mark.parametrize("excitation", EVERY_GENERATOR, ids=lambda e: type(e).__name__)
def test_controller_plays_what_the_document_says(rig: Rig, excitation: Excitation) -> None:
    outcome, ticks, counts = play(rig, plan(excitation))
    assert (outcome.end, outcome.samples_lost) == (RecordEnd.DONE, 0)
    played = bounded(plan(excitation))
    length = run_length(played, rig.hello.tick_hz)
    assert length is not None
    inside = (ticks >= outcome.start_tick) & (ticks < outcome.start_tick + length)
    expected = sample_reference(played, ticks[inside] - outcome.start_tick, rig.hello.tick_hz)
    assert inside.sum() == length
    # Both sides compute in double precision and round half up: a tie may fall either way, by one count.
    assert np.abs(counts[inside] - expected / CURRENT_COUNT_A).max() <= 1.0


@pytest.mark.slow
def test_streamed_set_points_are_played_without_underrun(rig: Rig) -> None:
    values = tuple(0.4 * np.sin(np.arange(1000) * 0.05))
    outcome, ticks, counts = play(rig, plan(Setpoints(values_a=values, hold_s=0.0008)))
    assert (outcome.end, outcome.underruns) == (RecordEnd.DONE, 0)
    words = np.floor(np.asarray(values) / CURRENT_COUNT_A + 0.5)
    played = counts[counts.nonzero()[0][0] - 2 :][:2000]  # the first word is 0, held for two ticks
    np.testing.assert_array_equal(played, np.repeat(words, 2))


@pytest.mark.slow
def test_recording_is_complete_and_its_notes_tell_how_it_went(rig: Rig) -> None:
    sink, progress = Sink(), list[RecordProgress]()
    what = plan(Sine(amplitude_a=0.5, period_s=5.0), 30.0, centring=True)
    outcome = record(rig, what, sink, on_progress=progress.append)
    assert outcome.end is RecordEnd.DONE
    assert (outcome.samples_lost, outcome.gaps) == (0, 0)
    assert outcome.samples_received == outcome.samples_expected >= 75_000
    assert progress[-1].elapsed_s > progress[0].elapsed_s
    assert {"excitation", "parameters", "prediction", "run", "outcome"} <= set(sink.notes)
    assert not rig.armed


def test_excitation_beyond_the_travel_is_refused_before_the_drive_is_on(rig: Rig) -> None:
    with pytest.raises(
        ExcitationLimitError, match=r"predicted travel of .* rad exceeds the limit of 29\.8 rad"
    ):
        record(rig, plan(Sine(amplitude_a=0.1, offset_a=1.0, period_s=5.0), 100.0), Sink())
    assert not rig.armed


def test_stop_event_ends_the_run_with_the_drive_at_rest(rig: Rig) -> None:
    stop = threading.Event()
    what = plan(Sine(amplitude_a=0.5, period_s=5.0), 10_000.0, centring=True)
    outcome = record(rig, what, Sink(), on_progress=lambda progress: stop.set(), stop=stop)
    assert outcome.end is RecordEnd.STOPPED
    assert not rig.armed


def test_full_disk_ends_the_run_with_the_drive_at_rest(rig: Rig) -> None:
    what = plan(Sine(amplitude_a=0.5, period_s=5.0), 1000.0, centring=True)
    outcome = record(rig, what, Sink(room=50_000))
    assert outcome.end is RecordEnd.DISK_FULL
    assert "no space left" in outcome.text
    assert not rig.armed


def test_emergency_stop_by_another_thread_ends_the_run(rig: Rig) -> None:
    threads = [threading.Thread(target=rig.estop)]

    def press(progress: RecordProgress) -> None:
        if threads[0].ident is None:
            threads[0].start()

    what = plan(Sine(amplitude_a=0.5, period_s=5.0), 10_000.0, centring=True)
    outcome = record(rig, what, Sink(), on_progress=press)
    threads[0].join()
    assert outcome.end is RecordEnd.TRIPPED
    assert isinstance(outcome.error, DeviceFaultError)
    assert outcome.error.faults == 1 << FaultBit.ESTOP
    with pytest.raises(DeviceFaultError, match="estop: The emergency stop was pressed"):
        rig.arm()
    rig.clear_fault()
    rig.arm()


@pytest.mark.slow
def test_trip_of_the_controller_is_told_with_its_remedy(emulate: Emulate) -> None:
    with open_rig(str(emulate("surge", "max"))) as rig:
        outcome = record(rig, plan(Sine(amplitude_a=0.3, period_s=5.0), 60.0, centring=True), Sink())
    assert outcome.end is RecordEnd.TRIPPED
    assert "over_current: A phase current passed over_current_A. Check the motor cable" in outcome.text


@pytest.mark.slow
def test_noise_on_the_line_costs_frames_and_every_lost_sample_is_counted(emulate: Emulate) -> None:
    with open_rig(str(emulate("noisy_link", "max"))) as rig:
        outcome, ticks, _ = play(rig, plan(Sine(amplitude_a=0.5, period_s=5.0), 60.0, centring=True))
    assert outcome.end is RecordEnd.DONE
    assert outcome.samples_lost > 0
    # The last frame may be among the lost, and then lies behind the newest sample.
    assert 0 <= outcome.samples_expected - (ticks[-1] - ticks[0] + 1) <= 50


@pytest.mark.slow
def test_controller_that_restarts_in_mid_run_ends_it(emulate: Emulate, tmp_path: Path) -> None:
    (tmp_path / "restarting.yaml").write_text(
        "name: restarting\nseed: 3\nfaults:\n  - {name: reboot, at_s: 5.0}\n"
    )
    with open_rig(str(emulate("restarting", "max"))) as rig:
        outcome = record(rig, plan(Sine(amplitude_a=0.5, period_s=5.0), 60.0, centring=True), Sink())
        assert rig.reboots == 1
        assert not rig.armed
    assert outcome.end is RecordEnd.TRIPPED
    assert "the controller restarted in mid-run, the drive is off" in outcome.text


@pytest.mark.slow
def test_stream_goes_on_after_the_cable_was_pulled(emulate: Emulate) -> None:
    gaps: list[GapCause] = []
    # The cable is pulled after 12 s of the controller's time: a loaded machine must have opened the rig by then.
    with open_rig(str(emulate("interrupted", "5"))) as rig:
        rig.start_stream(StreamPlan())
        ticks = 0
        # As many calls as it takes: how many blocks one of them returns depends on the machine.
        deadline_s = time.monotonic() + 60.0
        while ticks <= 20 * 2500 and time.monotonic() < deadline_s:
            for block in rig.next_blocks(0.1):
                gaps.extend(gap.cause for gap in block.gaps)
                ticks = int(block.ticks[-1]) if block.ticks.size else ticks
        assert rig.reboots == 0
        assert rig.armed is False
    assert GapCause.RECONNECT in gaps


def test_capture_buffer_holds_every_tick_around_its_trigger(rig: Rig) -> None:
    what = CapturePlan(layout="control", trigger=Trigger.NOW, pretrigger_percent=25)
    depth = start_capture(what, rig.dictionary, rig.ask)
    capture = None
    for _ in range(200):
        capture = read_capture(what, rig.dictionary, rig.ask)
        if capture is not None:
            break
        rig.next_blocks(0.05)
    assert capture is not None
    assert {name: values.size for name, values in capture.counts.items()} == dict.fromkeys(
        ("current_ref", "current", "position"), depth
    )
    assert abs(int(capture.counts["position"].mean()) - 32768) < 2000


def test_taken_port_is_told(rig: Rig, emulate: Emulate) -> None:
    path = str(emulate("nominal", "max"))
    with open_rig(path), pytest.raises(PortError, match="taken by another program"):
        open_rig(path)


def test_wrong_baud_is_told_with_rates_to_try(emulate: Emulate) -> None:
    options = RigOptions(start_baud=57_600, baud=57_600)
    with pytest.raises(PortError, match="no controller answered at 57600 baud .*rates to try: 115200"):
        open_rig(str(emulate("nominal", "max")), options)
