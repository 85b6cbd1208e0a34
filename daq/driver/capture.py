"""The controller's capture buffer: every tick around a trigger, read out afterwards."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from daq.driver.handshake import expect
from daq.driver.parameters import Ask
from daq.errors import DeviceRefusedError
from daq.protocol.codes import StatusCode, Trigger
from daq.protocol.commands import CaptureArm, CaptureConfig, CaptureRead
from daq.protocol.dictionary import Dictionary
from daq.protocol.replies import CaptureConfigReply, CaptureReadReply

_READ_WORDS = 96


@dataclass(frozen=True, slots=True, kw_only=True)
class CapturePlan:
    """What to capture and when.

    Attributes:
        layout: Name of a layout of the dictionary.
        trigger: At once, when a channel rises through a level, or when the drive trips.
        decimation: Controller ticks per captured sample.
        pretrigger_percent: Share of the buffer kept from before the trigger.
        channel: Name of the channel that triggers (LEVEL only).
        level_counts: Level of that channel, raw counts (LEVEL only).
    """

    layout: str = "phases"
    trigger: Trigger = Trigger.NOW
    decimation: int = 1
    pretrigger_percent: int = 50
    channel: str = ""
    level_counts: int = 0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Capture:
    """A finished capture.

    Attributes:
        trigger_tick: Controller tick of the trigger sample, 32 bits.
        counts: Raw words by channel, each of shape (n,).
    """

    trigger_tick: int
    counts: dict[str, NDArray[np.int16] | NDArray[np.uint16]]


def start_capture(plan: CapturePlan, dictionary: Dictionary, ask: Ask) -> int:
    """Set up and arm the capture buffer; return the samples that it will hold.

    Raises:
        KeyError: No such layout.
        ValueError: The trigger's channel is not in the layout.
        DeviceRefusedError: The controller refuses the plan.
    """
    layout = dictionary.layout(plan.layout)
    channel = 0
    if plan.trigger is Trigger.LEVEL:
        if plan.channel not in layout.channels:
            known = ", ".join(layout.channels)
            raise ValueError(f"channel='{plan.channel}' is not in layout '{layout.name}'; use one of {known}")
        channel = layout.channels.index(plan.channel)
    command = CaptureConfig(
        layout=layout.id,
        decimation=plan.decimation,
        pretrigger_percent=plan.pretrigger_percent,
        trigger=int(plan.trigger),
        channel=channel,
        level=plan.level_counts,
    )
    detail = f"decimation={plan.decimation}, pretrigger_percent={plan.pretrigger_percent}"
    depth = expect(ask(command, detail), CaptureConfigReply).depth
    ask(CaptureArm(), "")
    return depth


def read_capture(plan: CapturePlan, dictionary: Dictionary, ask: Ask) -> Capture | None:
    """Return the capture, or None while its trigger has not come or the buffer is still filling.

    Raises:
        DeviceRefusedError: No capture was started.
    """
    octets, total, trigger_tick = bytearray(), 1, 0
    while len(octets) < 2 * total:
        try:
            part = expect(ask(CaptureRead(offset=len(octets) // 2, count=_READ_WORDS), ""), CaptureReadReply)
        except DeviceRefusedError as refusal:
            if refusal.status == StatusCode.NO_DATA:
                return None
            raise
        if part.total == 0 or not part.words:
            return None
        octets += part.words
        total, trigger_tick = part.total, part.trigger_tick
    names = dictionary.layout(plan.layout).channels
    columns = np.ascontiguousarray(np.frombuffer(bytes(octets), "<i2").reshape(-1, len(names)).T)
    counts = {
        name: column.view(dictionary.channel(name).type.dtype)
        for name, column in zip(names, columns, strict=True)
    }
    return Capture(trigger_tick=trigger_tick, counts=counts)
