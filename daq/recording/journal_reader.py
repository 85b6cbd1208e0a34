"""Reads journals: live ones up to now, closed ones, compressed ones, and those a killed process left behind.

The octets go through the decoder and the assembler of the live path, so the blocks hold the numbers that were
seen live.
"""

import hashlib
import json
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import pyarrow as pa

from daq.driver.sink import LINK_LOST_KIND
from daq.errors import RecordingError
from daq.protocol.framing import FrameCounters, FrameDecoder
from daq.protocol.messages import encode_message
from daq.protocol.replies import StreamConfigReply
from daq.protocol.stream import LINK_LOST, SampleBlock, StreamAssembler
from daq.recording.header import check_header, dictionary_of
from daq.recording.journal import CLOSED_KIND, HEADER_TYPE, NOTE_TYPE

ARCHIVE_SUFFIX: Final = ".zst"
_CHUNK_OCTETS: Final = 1 << 20


@dataclass(frozen=True, slots=True, kw_only=True)
class Note:
    """A remark of the host: its kind and JSON values."""

    kind: str
    data: Mapping[str, Any]


class JournalReader:
    """Reads one journal, in pieces that fit the memory.

    `header` is there at once; `notes`, `counters`, `octets` and `sha256` are complete when `blocks` has been
    exhausted.

    Args:
        path: a journal, or one compressed by finalising (`.zst`).

    Raises:
        RecordingError: the file is no journal, or its header is cut off.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.notes: list[Note] = []
        self.octets = 0
        self._decoder = FrameDecoder(max_message=None)
        self._hash = hashlib.sha256()
        self._chunks = self._read_chunks()
        self._early = self._read_until_header()
        self.header = self._parse_header()
        self._assembler = StreamAssembler(dictionary_of(self.header))

    @property
    def counters(self) -> FrameCounters:
        """What the decoder has seen so far."""
        return self._decoder.counters

    @property
    def sha256(self) -> str:
        """Hash of the (uncompressed) octets read so far."""
        return self._hash.hexdigest()

    @property
    def closing(self) -> Note | None:
        """The note of how the recording ended, None while it is open or was left open."""
        return next((note for note in reversed(self.notes) if note.kind == CLOSED_KIND), None)

    def blocks(self) -> Iterator[SampleBlock]:
        """Yield the samples in their order; can be used once."""
        divisor = int(self.header["divisor"])
        configured = StreamConfigReply(status=0, layout=0, divisor=divisor, batch=0)
        yield from self._assembler.feed([encode_message(0, configured)])
        yield from self._take(self._early[1:])
        for chunk in self._chunks:
            yield from self._take(self._decoder.feed(chunk))

    def _take(self, bodies: list[bytes]) -> list[SampleBlock]:
        """Keep the notes and assemble the rest, with the mark that the live path has where the link was lost."""
        messages = []
        for body in bodies:
            if body[0] != NOTE_TYPE:
                messages.append(body)
                continue
            note = _parse_note(body)
            self.notes.append(note)
            if note.kind == LINK_LOST_KIND:
                messages.append(LINK_LOST)
        return self._assembler.feed(messages)

    def _read_chunks(self) -> Iterator[bytes]:
        compression = "zstd" if self.path.suffix == ARCHIVE_SUFFIX else None
        try:
            with pa.input_stream(str(self.path), compression=compression) as stream:
                while chunk := stream.read(_CHUNK_OCTETS):
                    self.octets += len(chunk)
                    self._hash.update(chunk)
                    yield chunk
        except OSError as error:
            raise RecordingError(f"cannot read journal {self.path}: {error}") from error

    def _read_until_header(self) -> list[bytes]:
        for chunk in self._chunks:
            if bodies := self._decoder.feed(chunk):
                return bodies
        return []

    def _parse_header(self) -> dict[str, Any]:
        if not self._early or self._early[0][0] != HEADER_TYPE:
            raise RecordingError(
                f"{self.path} is no journal, or was cut off within its header ({self.octets} octets)"
            )
        header: dict[str, Any] = _parse_json(self._early[0])
        check_header(header)
        return header


@dataclass(frozen=True, slots=True, kw_only=True)
class JournalContent:
    """A whole journal in memory.

    Attributes:
        header: what was known at the start.
        notes: remarks of the host, in their order.
        blocks: the samples, in their order.
        closed: True where the recording was ended and not cut off.
    """

    header: Mapping[str, Any]
    notes: tuple[Note, ...]
    blocks: tuple[SampleBlock, ...]
    closed: bool


def read_journal(path: Path) -> JournalContent:
    """Read a whole journal; an hour of three channels at 2.5 kHz takes about 150 MB of memory.

    Raises:
        RecordingError: the file is no journal, or its header is cut off.
    """
    reader = JournalReader(path)
    blocks = tuple(reader.blocks())
    return JournalContent(
        header=reader.header, notes=tuple(reader.notes), blocks=blocks, closed=reader.closing is not None
    )


def _parse_note(body: bytes) -> Note:
    content = _parse_json(body)
    return Note(kind=content["kind"], data=content["data"])


def _parse_json(body: bytes) -> Any:  # JSON values
    # decompressobj: the octet that may pad the frame to an even length is no part of the compressed text.
    return json.loads(zlib.decompressobj().decompress(body[2:]))
