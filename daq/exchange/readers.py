"""Reads the columns of foreign files as they are: names and numbers, no units, no judgement."""

from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from daq.errors import RecordingError

FloatArray = npt.NDArray[np.float64]
Columns = dict[str, FloatArray]

_GZIP_MAGIC: Final = b"\x1f\x8b"


def read_columns(path: Path) -> Columns:
    """Read every numeric vector of a file; its ending says what it is (see `READERS`).

    Raises:
        RecordingError: no such file, an unknown kind, or damaged.
    """
    reader = READERS.get(_kind(path))
    if reader is None:
        raise RecordingError(f"cannot read {path}: the kinds known are {', '.join(READERS)}")
    if not path.is_file():
        raise RecordingError(f"cannot read {path}: there is no such file")
    columns = reader(path)
    if not columns:
        raise RecordingError(f"{path} has no numeric columns")
    return columns


def _kind(path: Path) -> str:
    suffixes = [suffix.lower() for suffix in path.suffixes[-2:]]
    return "".join(suffixes) if suffixes[-1:] == [".gz"] else (suffixes or [""])[-1]


def _read_csv(path: Path) -> Columns:
    import pyarrow as pa  # slow to import, needed only here
    from pyarrow import csv

    with path.open("rb") as file:
        compression = "gzip" if file.read(2) == _GZIP_MAGIC else None
    try:
        with pa.input_stream(str(path), compression=compression) as stream:
            text = stream.read()
        options = csv.ParseOptions(delimiter=_separator(text[:10_000].split(b"\n", 1)[0]))
        return _from_table(csv.read_csv(pa.BufferReader(text), parse_options=options), path)
    except (OSError, pa.ArrowInvalid) as error:
        raise RecordingError(f"cannot read {path}: {error}") from error


def _separator(first_line: bytes) -> str:
    return max((",", ";", "\t"), key=lambda separator: first_line.count(separator.encode()))


def _read_parquet(path: Path) -> Columns:
    import pyarrow as pa  # slow to import, needed only here
    import pyarrow.parquet as pq

    try:
        return _from_table(pq.read_table(path), path)
    except pa.ArrowInvalid as error:
        raise RecordingError(f"cannot read {path}: {error}") from error


def _from_table(table: Any, path: Path) -> Columns:  # pyarrow has no types
    columns: Columns = {}
    for name in table.column_names:
        column = table.column(name)
        try:
            columns[name] = column.cast("float64").to_numpy().copy()
        except (ValueError, NotImplementedError):  # pyarrow's errors are both: text, dates, lists
            if name.endswith("_s") or column.null_count == len(column):
                raise RecordingError(f"{path}: column {name!r} holds {column.type}, not numbers") from None
    return columns


def _read_mat(path: Path) -> Columns:
    from scipy.io import loadmat  # slow to import, needed only here

    try:
        variables = loadmat(path, simplify_cells=True)
    except NotImplementedError:  # scipy's way of saying: version 7.3, which is HDF5
        return _read_hdf5(path)
    except (ValueError, TypeError) as error:
        raise RecordingError(f"cannot read {path}: {error}") from error
    return _vectors(variables)


def _read_hdf5(path: Path) -> Columns:
    import h5py  # slow to import, needed only here

    columns: Columns = {}

    def visit(name: str, item: Any) -> None:  # h5py has no types
        if isinstance(item, h5py.Dataset) and item.dtype.kind in "fiub":
            columns.update(_vectors({name.rsplit("/", 1)[-1]: item[()]}))

    try:
        with h5py.File(path, "r") as file:
            file.visititems(visit)
    except OSError as error:
        raise RecordingError(f"cannot read {path}: {error}") from error
    return columns


def _vectors(variables: Mapping[str, Any]) -> Columns:
    """Take the numeric vectors of a variable table, rows or columns, also those inside structures."""
    columns: Columns = {}
    for name, value in variables.items():
        if isinstance(value, Mapping):
            columns.update(_vectors(value))
            continue
        array = np.asarray(value)
        if (
            not name.startswith("__")
            and array.dtype.kind in "fiub"
            and array.size == max(array.shape, default=0) > 1
        ):
            columns[name] = array.astype(np.float64).reshape(-1)
    return columns


READERS: Final[Mapping[str, Callable[[Path], Columns]]] = MappingProxyType(
    {
        ".csv": _read_csv,
        ".csv.gz": _read_csv,
        ".parquet": _read_parquet,
        ".mat": _read_mat,
        ".h5": _read_hdf5,
        ".hdf5": _read_hdf5,
    }
)
