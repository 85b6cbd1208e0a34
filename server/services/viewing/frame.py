"""One binary frame of live data; docs/live.md is the reference, for clients in any language."""

import struct
from dataclasses import dataclass
from enum import IntFlag

import numpy as np
from numpy.typing import NDArray

MAGIC = b"JSLV"
VERSION = 1
_HEADER = struct.Struct("<4s6H2IqdQQqqQ")
HEADER_OCTETS = _HEADER.size
Float32 = NDArray[np.float32]


class FrameFlag(IntFlag):
    """Bits of a frame's flag word."""

    MIN_MAX = 1
    BREAK = 2


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LiveFrame:
    """Rows of live data and what a viewer should know about them.

    Attributes:
        plan: number of the plan that was in force.
        flags: see `FrameFlag`.
        samples_per_row: samples that each row stands for.
        first_tick: controller tick of the first row, 64 bits.
        row_s: time from a row to the next, s.
        dropped: samples that this viewer lost so far because it read too slowly.
        lost: samples that were missing on the line since it began to watch.
        newest_ns: wall clock of the newest sample in it, ns since 1970; 0 when unknown.
        sent_ns: wall clock when the frame was made, the same.
        number: of this viewer's frame, from 0.
        values: shape (columns, rows); with MIN_MAX (2 columns, rows): least and greatest of each column in turn.
    """

    plan: int
    flags: FrameFlag
    samples_per_row: int
    first_tick: int
    row_s: float
    dropped: int
    lost: int
    newest_ns: int
    sent_ns: int
    number: int
    values: Float32


def encode_live(frame: LiveFrame) -> bytes:
    """Return the frame's octets."""
    columns, rows = frame.values.shape
    header = _HEADER.pack(
        MAGIC,
        VERSION,
        HEADER_OCTETS,
        frame.plan & 0xFFFF,
        frame.flags,
        columns,
        0,
        rows,
        frame.samples_per_row,
        frame.first_tick,
        frame.row_s,
        frame.dropped,
        frame.lost,
        frame.newest_ns,
        frame.sent_ns,
        frame.number,
    )
    return header + frame.values.astype("<f4", copy=False).tobytes()


def decode_live(octets: bytes) -> LiveFrame:
    """Return the frame of these octets.

    Raises:
        ValueError: it is no such frame, of another version, or cut off.
    """
    if len(octets) < HEADER_OCTETS or octets[:4] != MAGIC:
        raise ValueError(f"{len(octets)} octets that begin with {octets[:4]!r} are no frame of live data")
    _, version, header, plan, flags, columns, _, rows, per_row, *rest = _HEADER.unpack_from(octets)
    if version != VERSION:
        raise ValueError(
            f"version {version} of the live frame is not known here; this program reads {VERSION}"
        )
    if len(octets) != header + 4 * columns * rows:
        raise ValueError(f"{columns} columns of {rows} rows do not fit {len(octets)} octets")
    first_tick, row_s, dropped, lost, newest_ns, sent_ns, number = rest
    values = np.frombuffer(octets, "<f4", columns * rows, header).reshape(columns, rows)
    return LiveFrame(
        plan=plan,
        flags=FrameFlag(flags),
        samples_per_row=per_row,
        first_tick=first_tick,
        row_s=row_s,
        dropped=dropped,
        lost=lost,
        newest_ns=newest_ns,
        sent_ns=sent_ns,
        number=number,
        values=values,
    )
