"""Controllers' dictionaries on disk, by CRC: a known controller need not send its own again."""

import os
import zlib
from pathlib import Path


class DictionaryCache:
    """A folder of files named after the CRC-32 of their octets; a damaged file counts as absent."""

    def __init__(self, folder: Path | None) -> None:
        self._folder = folder

    def load(self, crc: int) -> bytes | None:
        """Return the octets whose CRC-32 is `crc`, or None when they are not there."""
        if self._folder is None:
            return None
        try:
            octets = self._path(self._folder, crc).read_bytes()
        except OSError:
            return None
        return octets if zlib.crc32(octets) == crc else None

    def store(self, octets: bytes) -> None:
        """Keep `octets`; a folder that cannot be written costs time at the next start, nothing else."""
        if self._folder is None:
            return
        path = self._path(self._folder, zlib.crc32(octets))
        scratch = path.with_suffix(f".{os.getpid()}")
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            scratch.write_bytes(octets)
            scratch.replace(path)
        except OSError:
            scratch.unlink(missing_ok=True)

    @staticmethod
    def _path(folder: Path, crc: int) -> Path:
        return folder / f"dictionary-{crc:08x}.bin"
