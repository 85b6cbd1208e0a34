"""The live recording: an append-only file of the frames as they came off the wire.

Theory of operation. The reader thread hands over every octet it received *before* anything decodes or judges
it, and each hand-over is one unbuffered `write`: what the call has returned for is in the kernel, and a
killed process loses none of it (a power cut can lose what `sync` has not yet forced out). The first frame is
the header, notes of the host (clock fit, link statistics, events, how it ended) are frames of their own
between the controller's, so one decoder reads a journal, live or years later, and damage costs only the
frames it hits.

A journal has one writer: it holds a lock on the file, by which a recovery in another process sees that the
journal is alive. This file writes; `daq.recording.journal_reader` reads.
"""

import contextlib
import fcntl
import json
import os
import threading
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from daq.driver.sink import LINK_LOST_KIND
from daq.errors import JournalWriteError
from daq.protocol.framing import DELIMITER, encode_frame

HEADER_TYPE: Final = 0xF0
NOTE_TYPE: Final = 0xF1
CLOSED_KIND: Final = "closed"
JOURNAL_SUFFIX: Final = ".journal"


class Journal:
    """Writes one journal; make it with `Journal.create`.

    `append` belongs to the reader thread and `note` to the task that handles the data; both may run at once.
    """

    def __init__(self, path: Path, descriptor: int) -> None:
        self.path = path
        self.octets = 0
        self._descriptor = descriptor
        self._lock = threading.Lock()
        self._mid_frame = False
        self._waiting_notes: list[bytes] = []
        self._failure: JournalWriteError | None = None

    @classmethod
    def create(cls, path: Path, header: Mapping[str, Any]) -> "Journal":
        """Create the file, lock it and write its header.

        Args:
            path: a new file; by custom it ends in `.journal`, which is what recovery looks for.
            header: JSON values, see `daq.recording.header.make_header`.

        Raises:
            JournalWriteError: the file exists already, or the disk is full or refuses.
        """
        try:
            descriptor = os.open(
                path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_APPEND | os.O_CLOEXEC, 0o644
            )
        except OSError as error:
            raise JournalWriteError(f"cannot create journal {path}: {error.strerror}") from error
        fcntl.flock(descriptor, fcntl.LOCK_EX)
        journal = cls(path, descriptor)
        try:
            journal._write(_json_frame(HEADER_TYPE, header))
        except JournalWriteError:
            os.close(descriptor)
            path.unlink()
            raise
        return journal

    def append(self, raw: bytes) -> None:
        """Write received octets. They need not end with a frame; notes wait until one does.

        Raises:
            JournalWriteError: the disk is full or the journal is closed; the file stays readable.
        """
        if not raw:
            return
        with self._lock:  # keeps notes from landing inside a frame; nobody holds it for longer than one write
            if self._waiting_notes and DELIMITER in raw:
                end = raw.rindex(DELIMITER) + 1
                raw = b"".join([raw[:end], *self._waiting_notes, raw[end:]])
                self._waiting_notes.clear()
            self._write(raw)
            self._mid_frame = not raw.endswith(DELIMITER)

    def note(self, kind: str, data: Mapping[str, Any]) -> None:
        """Write a remark of the host at this place in the stream, or at the end of the frame under way.

        A frame that a lost link cut off is ended first: its rest will not come, and what comes next is no part of it.

        Args:
            kind: what it is, for example `clock_fit`; see docs/recordings.md for the kinds that finalising
                knows.
            data: JSON values.

        Raises:
            JournalWriteError: the disk is full or the journal is closed; the file stays readable.
        """
        frame = _json_frame(NOTE_TYPE, {"kind": kind, "data": data})
        with self._lock:
            if not self._mid_frame:
                self._write(frame)
            elif kind == LINK_LOST_KIND:
                self._write(b"".join([DELIMITER, *self._waiting_notes, frame]))
                self._waiting_notes.clear()
                self._mid_frame = False
            else:
                self._waiting_notes.append(frame)

    def sync(self) -> None:
        """Force what was written onto the medium, which bounds what a power cut can take.

        Raises:
            JournalWriteError: the medium refuses; some systems only now say that it is full.
        """
        if self._descriptor < 0:
            return
        try:
            os.fdatasync(self._descriptor)
        except OSError as error:
            raise JournalWriteError(f"journal {self.path} cannot be synced: {error.strerror}") from error

    def close(self, reason: str, **details: Any) -> None:  # JSON values
        """Note how the recording ended and release the file; closing twice is harmless.

        Args:
            reason: how it ended in a word or two: `done`, `aborted`, `fault`, `lost`.
            details: further JSON values about the end.
        """
        with self._lock:
            if self._descriptor < 0:
                return
            closing = _json_frame(NOTE_TYPE, {"kind": CLOSED_KIND, "data": {**details, "reason": reason}})
            # A delimiter first ends a frame that was cut off, so that the notes behind it stand alone.
            cut_off = [DELIMITER] if self._mid_frame else []
            # A full disk was reported when it filled up; the end must still release the file.
            with contextlib.suppress(JournalWriteError):
                self._write(b"".join([*cut_off, *self._waiting_notes, closing]))
            with contextlib.suppress(OSError):
                os.fdatasync(self._descriptor)
            os.close(self._descriptor)
            self._descriptor = -1

    def _write(self, raw: bytes) -> None:
        if self._failure is not None:
            raise self._failure
        if self._descriptor < 0:
            raise JournalWriteError(f"journal {self.path} is closed; nothing more can be recorded into it")
        view = memoryview(raw)
        while view:
            try:
                written = os.write(self._descriptor, view)
            except OSError as error:
                self._failure = JournalWriteError(
                    f"journal {self.path} cannot be written after {self.octets} octets: {error.strerror}; "
                    "free some space and start a new recording (what was written stays readable)"
                )
                raise self._failure from error
            self.octets += written
            view = view[written:]


def _json_frame(frame_type: int, content: Mapping[str, Any]) -> bytes:
    octets = zlib.compress(json.dumps(content, allow_nan=True).encode())
    padding = b"\x00" * (len(octets) % 2)  # frames hold whole 16-bit words; zlib ignores what follows its end
    return encode_frame(bytes([frame_type, 0]) + octets + padding, max_message=None)
