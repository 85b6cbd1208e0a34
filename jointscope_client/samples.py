"""Samples of a recording as numpy arrays."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

ARROW_TYPE = "application/vnd.apache.arrow.stream"
GAP = "gap"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Samples:
    """Columns of equal length.

    Attributes:
        columns: float64 values by name, shape (rows,); with `points`, `NAME_min` and `NAME_max`.
        gap: shape (rows,): samples are missing just before this one.
        units: unit of each column.
        of_rows: how many samples the span has, before it was thinned out.
        sample_time_s: nominal time between the recording's samples.
    """

    columns: Mapping[str, npt.NDArray[np.float64]]
    gap: npt.NDArray[np.bool_]
    units: Mapping[str, str]
    of_rows: int
    sample_time_s: float

    @property
    def rows(self) -> int:
        """How many rows there are."""
        return len(self.gap)

    @property
    def time_s(self) -> npt.NDArray[np.float64]:
        """Time from the recording's first sample, s."""
        return self.columns["time_s"]

    def __getitem__(self, name: str) -> npt.NDArray[np.float64]:
        """Return a column."""
        return self.columns[name]


def read_arrow(octets: bytes) -> Samples:
    """Read what the service sends as an Arrow IPC stream."""
    import pyarrow as pa  # slow to import, needed only here

    table: Any = pa.ipc.open_stream(octets).read_all()  # pyarrow has no types
    arrays = {name: table.column(name).to_numpy() for name in table.column_names}
    facts = table.schema.metadata
    return Samples(
        columns={name: values for name, values in arrays.items() if name != GAP},
        gap=arrays[GAP].astype(np.bool_),
        units=json.loads(facts[b"units"]),
        of_rows=int(facts[b"of_rows"]),
        sample_time_s=float(facts[b"sample_time_s"]),
    )
