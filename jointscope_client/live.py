"""Live data: the binary frames of docs/live.md to numpy arrays. No I/O here."""

import json
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any
from urllib.parse import urlencode

import numpy as np
import numpy.typing as npt

from jointscope_client.calls import path_of
from jointscope_client.errors import ClientError, InvalidError

# magic, version, header octets, plan, flags, arrays, 0, rows, samples per row, tick, row time, lost by the viewer,
# missing on the line, wall clock of the newest sample, wall clock of the frame, number of the frame
HEADER = struct.Struct("<4sHHHHHHIIqdQQqqQ")
MAGIC, VERSION = b"JSLV", 1
EXTREMES, AFTER_HOLE = 1, 2


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LiveFrame:
    """Samples that came together.

    Attributes:
        columns: float32 values by name, shape (rows,); with a rate chosen, `NAME_min` and `NAME_max`.
        units: unit of each column.
        rows: how many there are; 0 in the frames that only say that the rig is idle.
        tick: controller tick of the first row.
        row_time_s: from a row to the next.
        samples_per_row: samples that a row stands for.
        after_hole: samples are missing before the first row, or it is the first of all.
        lost: samples that this viewer lost so far by reading too slowly.
        missing: samples missing on the line since it began.
        newest_ns: wall clock of the newest sample, ns since 1970; 0 when unknown.
        made_ns: wall clock when the frame was made, ns since 1970.
        number: of the frame, from 0.
    """

    columns: Mapping[str, npt.NDArray[np.float32]]
    units: Mapping[str, str]
    rows: int
    tick: int
    row_time_s: float
    samples_per_row: int
    after_hole: bool
    lost: int
    missing: int
    newest_ns: int
    made_ns: int
    number: int

    def __getitem__(self, name: str) -> npt.NDArray[np.float32]:
        """Return a column."""
        return self.columns[name]


class LiveDecoder:
    """Makes frames of a connection's messages; remembers the plans that they refer to."""

    def __init__(self) -> None:
        self._plans: dict[int, list[tuple[str, str]]] = {}

    def feed(self, message: str | bytes) -> LiveFrame | None:
        """Take a message; None for those that are no samples.

        Raises:
            InvalidError: the service refuses the columns or the rate that were chosen.
            ClientError: a frame of a version that this client does not know.
        """
        if isinstance(message, str):
            self._hear(json.loads(message))
            return None
        return self._decode(message)

    def _hear(self, content: Mapping[str, Any]) -> None:  # JSON values
        if content.get("type") == "problem":
            raise InvalidError({**content, "status": 422, "type": "/problems/invalid-value"})
        if content.get("type") == "plan":
            names = [(each["name"], each["unit"]) for each in content["columns"]]
            self._plans[content["plan"] % 65536] = names

    def _decode(self, octets: bytes) -> LiveFrame:
        header = HEADER.unpack_from(octets)
        magic, version, size, plan, flags, arrays, _, rows, per_row, tick, row_time_s, *counters = header
        if magic != MAGIC or version != VERSION:
            raise ClientError(
                f"a live frame of version {version} cannot be read, only {VERSION}; update jointscope"
            )
        known = self._plans[plan]
        names = _names([name for name, _ in known], bool(flags & EXTREMES))
        if rows:
            values = np.frombuffer(octets, dtype="<f4", count=arrays * rows, offset=size).reshape(
                arrays, rows
            )
        else:  # sent by an idle rig, mostly without any arrays
            values = np.empty((len(names), 0), dtype=np.float32)
        units = [unit for _, unit in known for _ in range(2 if flags & EXTREMES else 1)]
        lost, missing, newest_ns, made_ns, number = counters
        return LiveFrame(
            columns=dict(zip(names, values, strict=True)),
            units=dict(zip(names, units, strict=True)),
            rows=rows,
            tick=tick,
            row_time_s=row_time_s,
            samples_per_row=per_row,
            after_hole=bool(flags & AFTER_HOLE),
            lost=lost,
            missing=missing,
            newest_ns=newest_ns,
            made_ns=made_ns,
            number=number,
        )


def live_url(url: str, rig_id: str, columns: Sequence[str], rate_hz: float | None, interval_ms: int) -> str:
    """Return the address of a rig's live data."""
    query: dict[str, object] = {"interval_ms": interval_ms}
    if columns:
        query["columns"] = ",".join(columns)
    if rate_hz is not None:
        query["rate_hz"] = rate_hz
    return f"ws{url.removeprefix('http')}{path_of('rigs', rig_id, 'live')}?{urlencode(query)}"


def _names(columns: Sequence[str], extremes: bool) -> list[str]:
    if not extremes:
        return list(columns)
    return [name + ending for name in columns for ending in ("_min", "_max")]
