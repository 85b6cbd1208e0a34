"""Looks at an uploaded file before it is read: what it unpacks to, and whether it reaches for other files.

Runs in the importer's process only, since it opens what strangers sent.
"""

import gzip
from pathlib import Path

from daq.errors import RecordingError

_CHUNK = 1 << 20


def inspect_file(path: Path, limit: int) -> None:
    """Refuse a trap.

    Raises:
        RecordingError: it unpacks to more than `limit` octets, or is an HDF5 file (or MAT 7.3, which is one) whose
            samples lie in other files of this machine.
    """
    import h5py  # slow to import, needed only here

    ending = path.suffix.lower()
    if h5py.is_hdf5(path):
        unpacked = _inspect_hdf5(path)
    elif ending == ".parquet":
        unpacked = _parquet_octets(path)
    elif ending in (".gz", ".csv"):
        unpacked = _gzip_octets(path, limit)
    else:
        return  # MAT 5 tells only while it is read; the limit of the memory ends that
    if unpacked > limit:
        raise RecordingError(f"unpacks to more than {limit:,} octets; split it, or send it unpacked")


def _inspect_hdf5(path: Path) -> int:
    import h5py

    sizes: list[int] = []

    def visit(name: str, item: object) -> None:
        if isinstance(item, h5py.Dataset):
            if item.external or item.is_virtual:
                raise RecordingError(f"{name!r} keeps its samples in another file; copy them into this one")
            sizes.append(int(item.nbytes))

    with h5py.File(path, "r") as file:
        file.visititems(visit)
    return sum(sizes)


def _parquet_octets(path: Path) -> int:
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        footer = pq.read_metadata(path)
    except pa.ArrowInvalid:
        return 0  # the importer says what is wrong with it
    return int(footer.num_rows) * int(footer.num_columns) * 8


def _gzip_octets(path: Path, limit: int) -> int:
    """Return what a file unpacks to, counted until it is too much; 0 for one that is not compressed."""
    total = 0
    try:
        with gzip.open(path) as file:
            while total <= limit and (chunk := file.read(_CHUNK)):
                total += len(chunk)
    except gzip.BadGzipFile:
        return 0
    return total
