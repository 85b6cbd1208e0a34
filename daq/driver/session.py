"""One recording with the drive on, from the check of its excitation to the drive at rest.

Theory of operation. The data task (whoever calls `record`) pulls blocks, and with each batch of them renews the lease
and feeds set-points: when it stops for whatever reason, the controller ramps down by itself. Everything that can end a
recording (its time is over, somebody stops it, the drive trips, the link or the disk fails) leads to the same way out:
disarm, wait until the drive rests, stop the stream, keep what is still under way.
"""

import threading
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict

from daq.driver.options import RecordPlan
from daq.driver.outcome import RecordEnd, RecordOutcome, RecordProgress
from daq.driver.preflight import bounded, check_plan, describe_excitation
from daq.driver.rig import Rig
from daq.driver.run_watch import RunWatch
from daq.driver.setpoint_feeder import SetpointFeeder
from daq.driver.sink import RecordSink
from daq.errors import (
    DaqError,
    DeviceFaultError,
    DeviceRefusedError,
    JournalWriteError,
    LinkTimeoutError,
    PortError,
)
from daq.excitation.spec import Setpoints
from daq.protocol.codes import DriveState
from daq.protocol.stream import SampleBlock

_PULL_S = 0.1
_PROGRESS_S = 0.05
_REST_S = 2.0
OnProgress = Callable[[RecordProgress], None]
OnBlocks = Callable[[list[SampleBlock]], None]


def record(
    rig: Rig,
    plan: RecordPlan,
    sink: RecordSink,
    on_progress: OnProgress | None = None,
    on_blocks: OnBlocks | None = None,
    stop: threading.Event | None = None,
) -> RecordOutcome:
    """Play an excitation and record what the rig does.

    Args:
        rig: An open rig, its drive off.
        plan: What to play and to record.
        sink: Gets every received octet; the caller closes it afterwards, with the outcome's `end`.
        on_progress: Told about twenty times a second where the recording is.
        on_blocks: Gets all samples as they come; runs in the data task, so it must be quick.
        stop: Set by another thread to end the recording early. Ctrl-C does the same.

    Returns:
        How it went. What goes wrong once the drive is on ends the recording and is in the outcome.

    Raises:
        ExcitationLimitError: The excitation exceeds a limit; nothing was switched on.
        WireBudgetError: The stream does not fit the line.
        DeviceRefusedError: The controller refused stream, drive or excitation.
        DeviceFaultError: A fault is latched.
    """
    report = check_plan(rig, plan)
    run = _Run(rig, plan, stop or threading.Event())
    rig.attach(sink)
    try:
        sink.note("excitation", describe_excitation(bounded(plan)))
        sink.note("parameters", rig.parameters.read_all())
        sink.note("prediction", asdict(report))
        end, error = run.play(sink, on_progress, on_blocks)
        outcome = run.watch.outcome(end, error, report)
        with suppress(
            JournalWriteError
        ):  # a full disk has ended the recording already, or does no harm any more
            sink.note("outcome", {"end": end.value, "text": outcome.text, "start_tick": outcome.start_tick})
        return outcome
    finally:
        rig.detach()


class _Run:
    """The part of a recording in which the stream runs."""

    def __init__(self, rig: Rig, plan: RecordPlan, stop: threading.Event) -> None:
        self._rig = rig
        self._plan = plan
        self._stop = stop
        self._feeder: SetpointFeeder | None = None
        self._told_s = 0.0
        self.watch = RunWatch(rig, plan.duration_s)

    def play(
        self, sink: RecordSink, on_progress: OnProgress | None, on_blocks: OnBlocks | None
    ) -> tuple[RecordEnd, DaqError | None]:
        """Arm, stream, run until something ends it, and leave the drive at rest."""
        rig = self._rig
        # Armed first: an emulated controller at full speed then waits for us instead of running ahead, and the
        # samples before the excitation are few.
        rig.arm(self._plan.lease_ms)
        try:
            rig.start_stream(self._plan.stream)
            self._begin(sink, on_blocks)
            return self._pull_until_end(on_progress, on_blocks)
        except KeyboardInterrupt:
            return RecordEnd.STOPPED, None
        except (DeviceFaultError, DeviceRefusedError) as error:
            if self.watch.start_tick is None:
                raise
            return RecordEnd.TRIPPED, error
        except JournalWriteError as error:
            rig.detach()
            return RecordEnd.DISK_FULL, error
        except (LinkTimeoutError, PortError) as error:
            return RecordEnd.LINK_LOST, error
        finally:
            self._come_to_rest(on_blocks)

    def _begin(self, sink: RecordSink, on_blocks: OnBlocks | None) -> None:
        rig, centring, excitation = self._rig, self._plan.centring, bounded(self._plan)
        if isinstance(excitation, Setpoints):
            buffer = rig.dictionary.setpoint
            self._feeder = SetpointFeeder(excitation, rig.hello.tick_hz, buffer, rig.ask)
            start_tick = self._feeder.begin(centring=centring)
        else:
            start_tick = rig.run(excitation, centring=centring)
        self._take(rig.next_blocks(_PULL_S), on_blocks)
        self.watch.begin(start_tick)
        sink.note("run", {"start_tick": self.watch.start_tick})

    def _pull_until_end(
        self, on_progress: OnProgress | None, on_blocks: OnBlocks | None
    ) -> tuple[RecordEnd, DaqError | None]:
        while not self._stop.is_set():
            self._take(self._rig.next_blocks(_PULL_S), on_blocks)
            self._rig.keep_alive()
            if self._feeder is not None:
                self._feeder.feed(self.watch.newest_tick)
            self._tell(on_progress)
            self.watch.raise_trouble()  # first: after a lost link, the end of the time and a trip may come in one batch
            if self.watch.is_over():
                return RecordEnd.DONE, None
        return RecordEnd.STOPPED, None

    def _take(self, blocks: list[SampleBlock], on_blocks: OnBlocks | None) -> None:
        self.watch.heed(blocks, self._rig.events())
        if on_blocks is not None and blocks:
            on_blocks(blocks)

    def _tell(self, on_progress: OnProgress | None) -> None:
        now_s = time.monotonic()
        if on_progress is not None and now_s - self._told_s >= _PROGRESS_S:
            self._told_s = now_s
            on_progress(self.watch.progress())

    def _come_to_rest(self, on_blocks: OnBlocks | None) -> None:
        """Disarm, wait until the ramp is over, stop the stream, and take what is still under way.

        Without a link none of this is possible; the controller's lease does it.
        """
        rig = self._rig
        with suppress(PortError, LinkTimeoutError):
            rig.disarm()
            deadline_s = time.monotonic() + _REST_S
            while self.watch.state in _MOVING and time.monotonic() < deadline_s:
                self._take(rig.next_blocks(_PULL_S), on_blocks)
                rig.keep_alive()
            rig.stop_stream()
            self._take(rig.next_blocks(0.0), on_blocks)


_MOVING = (DriveState.ARMED, DriveState.RUNNING, DriveState.RAMPING)
