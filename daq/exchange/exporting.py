"""Writes a recording in the formats that other programs read; each in SI columns, `gap` flags beside them.

MDF4 and MCAP need libraries that are not installed by default; without them the message says how to get them.
"""

import json
from collections.abc import Callable, Mapping
from enum import Enum
from pathlib import Path
from types import MappingProxyType
from typing import Final

from daq.errors import RecordingError
from daq.exchange.logging_formats import write_mcap, write_mdf4
from daq.recording.recording import FloatArray, Recording
from daq.recording.store import GAP, write_recording


class ExportFormat(Enum):
    """The formats; the value is the name on the command line."""

    CSV = "csv"
    MAT = "mat"
    PARQUET = "parquet"
    HDF5 = "hdf5"
    MDF4 = "mdf4"
    MCAP = "mcap"


FILE_SUFFIXES: Final[Mapping[ExportFormat, str]] = MappingProxyType(
    {
        ExportFormat.CSV: ".csv",
        ExportFormat.MAT: ".mat",
        ExportFormat.PARQUET: ".parquet",
        ExportFormat.HDF5: ".h5",
        ExportFormat.MDF4: ".mf4",
        ExportFormat.MCAP: ".mcap",
    }
)


def export_recording(recording: Recording, path: Path, export_format: ExportFormat) -> Path:
    """Write a recording to `path`, which is replaced if it exists.

    Returns:
        `path`.

    Raises:
        RecordingError: the format needs a library that is not installed, or the file cannot be written.
    """
    try:
        _WRITERS[export_format](recording, path)
    except OSError as error:
        raise RecordingError(f"cannot write {path}: {error.strerror or error}") from error
    return path


def format_of(path: Path) -> ExportFormat:
    """Return the format that a file name's ending asks for.

    Raises:
        RecordingError: with the endings that are known.
    """
    for export_format, suffix in FILE_SUFFIXES.items():
        if path.suffix.lower() == suffix:
            return export_format
    raise RecordingError(f"cannot export to {path}: name it with one of {', '.join(FILE_SUFFIXES.values())}")


def _columns(recording: Recording) -> dict[str, FloatArray]:
    return {name: recording.column(name) for name in recording.columns}


def _write_csv(recording: Recording, path: Path) -> None:
    import pyarrow as pa  # slow to import, needed only here
    from pyarrow import csv

    # Arrow prints the shortest digits that read back to the same number.
    table = pa.table({**_columns(recording), GAP: recording.gap.astype("int8")})
    csv.write_csv(table, path, csv.WriteOptions(quoting_header="none"))


def _write_mat(recording: Recording, path: Path) -> None:
    from scipy.io import savemat  # slow to import, needed only here

    described = {"units": json.dumps(dict(recording.units)), "metadata": json.dumps(dict(recording.metadata))}
    columns = {**_columns(recording), GAP: recording.gap}
    savemat(path, {**columns, **described}, do_compression=True, oned_as="column", long_field_names=True)


def _write_parquet(recording: Recording, path: Path) -> None:
    write_recording(recording, path)


def _write_hdf5(recording: Recording, path: Path) -> None:
    import h5py  # slow to import, needed only here

    with h5py.File(path, "w") as file:
        for name, values in _columns(recording).items():
            dataset = file.create_dataset(name, data=values, compression="gzip", shuffle=True)
            dataset.attrs["unit"] = recording.units[name]
        file.create_dataset(GAP, data=recording.gap, compression="gzip")
        file.attrs["sample_time_s"] = recording.sample_time_s
        # A data set, since attributes are limited to 64 KiB.
        file.create_dataset("metadata", data=json.dumps(dict(recording.metadata)))


_WRITERS: Final[Mapping[ExportFormat, Callable[[Recording, Path], None]]] = MappingProxyType(
    {
        ExportFormat.CSV: _write_csv,
        ExportFormat.MAT: _write_mat,
        ExportFormat.PARQUET: _write_parquet,
        ExportFormat.HDF5: _write_hdf5,
        ExportFormat.MDF4: write_mdf4,
        ExportFormat.MCAP: write_mcap,
    }
)
