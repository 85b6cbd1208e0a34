"""Gaps of the link, placed on a recording's rows and written as JSON."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from daq.recording.recording import GapSpan

if TYPE_CHECKING:  # reading a recording needs nothing of the protocol, whose import takes its time
    from daq.protocol.stream import SampleBlock


def place_gaps(block: "SampleBlock", rows_before: int, first_tick: int, tick_hz: float) -> list[GapSpan]:
    """Return a block's gaps on the rows and the time axis of the whole recording.

    Args:
        block: samples and the gaps before, between or (in a block without samples) after them.
        rows_before: samples in the blocks before.
        first_tick: tick of the recording's first sample.
        tick_hz: ticks per second.
    """
    return [
        GapSpan(
            row=rows_before + int(np.searchsorted(block.ticks, gap.first_tick)),
            start_s=(gap.first_tick - first_tick) / tick_hz,
            missing_samples=gap.missing_samples,
            cause=gap.cause.value,
        )
        for gap in block.gaps
    ]


def gaps_to_json(gaps: Iterable[GapSpan]) -> list[dict[str, Any]]:
    """Return the gap table as JSON values."""
    return [asdict(gap) for gap in gaps]


def gaps_from_json(table: Sequence[Mapping[str, Any]]) -> tuple[GapSpan, ...]:
    """Return the gaps that `gaps_to_json` wrote."""
    return tuple(GapSpan(**entry) for entry in table)
