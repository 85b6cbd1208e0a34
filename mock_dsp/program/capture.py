"""The capture buffer: 4096 words around a trigger, frozen until it is armed again.

Before the trigger the buffer holds the newest `pretrigger` samples; the trigger sample is the first after
them. A trigger counts only once the pre-trigger part is full, so a finished capture has its full depth.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum, auto

import numpy as np
from numpy.typing import NDArray

from daq.protocol.codes import StatusCode, Trigger
from daq.protocol.commands import CaptureConfig
from daq.protocol.dictionary_entries import CountType, Layout
from mock_dsp.program.dictionary import CHANNELS, LAYOUTS

Words = NDArray[np.uint16]

BUFFER_WORDS = 4096
_LAYOUTS: Mapping[int, Layout] = {layout.id: layout for layout in LAYOUTS}
_TYPES: Mapping[str, CountType] = {channel.name: channel.type for channel in CHANNELS}


class CapturePhase(Enum):
    """How far a capture is."""

    OFF = auto()
    WAITING = auto()
    FILLING = auto()
    READY = auto()


@dataclass(frozen=True, slots=True, kw_only=True)
class CaptureSettings:
    """What CAPTURE_CONFIG sets; `depth` and `pretrigger` count samples."""

    layout: Layout
    decimation: int
    depth: int
    pretrigger: int
    trigger: Trigger
    channel: int
    level: int


def check_capture(command: CaptureConfig) -> CaptureSettings | StatusCode:
    """Return the settings, or why they are refused."""
    layout = _LAYOUTS.get(command.layout)
    if layout is None or command.decimation < 1 or command.pretrigger_percent > 100:
        return StatusCode.OUT_OF_RANGE
    if command.trigger not in tuple(Trigger) or command.channel >= len(layout.channels):
        return StatusCode.OUT_OF_RANGE
    depth = BUFFER_WORDS // len(layout.channels)
    return CaptureSettings(
        layout=layout,
        decimation=command.decimation,
        depth=depth,
        pretrigger=min(depth * command.pretrigger_percent // 100, depth - 1),
        trigger=Trigger(command.trigger),
        channel=command.channel,
        level=command.level,
    )


class CaptureRecorder:
    """Samples on their way into the capture buffer.

    Attributes:
        phase: how far it is.
        settings: what CAPTURE_CONFIG set, None before.
        trigger_time: time of the trigger sample, once there was one.
    """

    def __init__(self) -> None:
        self.phase = CapturePhase.OFF
        self.settings: CaptureSettings | None = None
        self.trigger_time = 0
        self._samples: Words = np.empty((0, 0), dtype=np.uint16)
        self._first_time = 0

    def configure(self, settings: CaptureSettings) -> None:
        """Take new settings; what was captured is gone."""
        self.settings = settings
        self.phase = CapturePhase.OFF

    def arm(self, time: int) -> None:
        """Start with the sample at `time`.

        Raises:
            ValueError: There are no settings.
        """
        if self.settings is None:
            raise ValueError("capture armed without settings; configure it first")
        self.phase = CapturePhase.WAITING
        self._samples = np.empty((0, len(self.settings.layout.channels)), dtype=np.uint16)
        self._first_time = time

    def feed(self, time: int, channels: Mapping[str, Words]) -> None:
        """Take a block of samples, one word a tick and channel, each of shape (n,), from `time` on."""
        settings = self.settings
        if settings is None or self.phase not in (CapturePhase.WAITING, CapturePhase.FILLING):
            return
        first = (self._first_time - time) % settings.decimation
        rows = np.stack(
            [channels[name][first :: settings.decimation] for name in settings.layout.channels], axis=1
        )
        held = len(self._samples)
        self._samples = np.concatenate((self._samples, rows))
        if self.phase is CapturePhase.WAITING:
            at = self._find_trigger(settings, held)
            if at is None:
                # One sample more than the pre-trigger part, so that a level is compared over the seam.
                self._drop_oldest(len(self._samples) - settings.pretrigger - 1)
                return
            self._trigger(settings, at)
        self._finish_if_full(settings)

    def notice_fault(self) -> None:
        """Trigger at the newest sample, if a trip is what the capture waits for and the past is there."""
        settings = self.settings
        if (
            settings is None
            or self.phase is not CapturePhase.WAITING
            or settings.trigger is not Trigger.FAULT
        ):
            return
        if len(self._samples) > settings.pretrigger:
            self._trigger(settings, len(self._samples) - 1)
            self._finish_if_full(settings)

    def read(self, offset: int, count: int) -> tuple[int, bytes]:
        """Return the number of words in all (0 while not ready) and `count` words from `offset`."""
        if self.phase is not CapturePhase.READY:
            return 0, b""
        words = self._samples.reshape(-1)
        return len(words), words[offset : offset + count].astype("<u2").tobytes()

    def _trigger(self, settings: CaptureSettings, at: int) -> None:
        self.trigger_time = self._first_time + at * settings.decimation
        self._drop_oldest(at - settings.pretrigger)
        self.phase = CapturePhase.FILLING

    def _finish_if_full(self, settings: CaptureSettings) -> None:
        if len(self._samples) >= settings.depth:
            self._samples = self._samples[: settings.depth]
            self.phase = CapturePhase.READY

    def _drop_oldest(self, count: int) -> None:
        if self.settings is not None and count > 0:
            self._samples = self._samples[count:]
            self._first_time += count * self.settings.decimation

    def _find_trigger(self, settings: CaptureSettings, held: int) -> int | None:
        """Return the row of the trigger sample among all rows; those from `held` on are new."""
        earliest = max(held, settings.pretrigger)
        if settings.trigger is Trigger.NOW:
            return earliest if earliest < len(self._samples) else None
        if settings.trigger is Trigger.FAULT:
            return None  # comes by `notice_fault`
        crossing = np.flatnonzero(self._crossings(settings)) + 1
        late_enough = crossing[crossing >= earliest]
        return int(late_enough[0]) if len(late_enough) else None

    def _crossings(self, settings: CaptureSettings) -> NDArray[np.bool_]:
        """Return where the channel rises from below the level to it or above, shape (rows - 1,)."""
        words = np.ascontiguousarray(self._samples[:, settings.channel])
        signed = _TYPES[settings.layout.channels[settings.channel]] is CountType.I16
        values = words.view(np.int16).astype(np.int32) if signed else words.astype(np.int32)
        level = settings.level if signed else settings.level & 0xFFFF
        above: NDArray[np.bool_] = values >= level
        return above[1:] & ~above[:-1]
