"""Where received octets are kept before anything judges them: the journal, or a list in a test."""

from collections.abc import Mapping
from typing import Any, Final, Protocol

from daq.errors import JournalWriteError

LINK_LOST_KIND: Final = "link_lost"
"""The note at the place where the link was lost: a frame under way there will never be completed."""


class RecordSink(Protocol):
    """Takes received octets and remarks; both may raise `JournalWriteError`."""

    def append(self, raw: bytes) -> None:
        """Keep octets as they came off the wire; called by the reader thread before anything judges them."""

    def note(self, kind: str, data: Mapping[str, Any]) -> None:  # JSON values
        """Keep a remark at this place of the stream; called by any thread."""


class SinkTap:
    """The place where a sink is put on the line and taken off again, over reconnects.

    A sink that fails is taken off, and `failure` says why: the octets must be decoded all the same, because the
    drive is stopped through this very line.
    """

    def __init__(self) -> None:
        self._sink: RecordSink | None = None
        self.failure: JournalWriteError | None = None

    def attach(self, sink: RecordSink) -> None:
        """Let `sink` have everything from now on."""
        self.failure = None
        self._sink = sink

    def detach(self) -> None:
        """Let nobody have anything; a failure is forgotten with the sink that had it."""
        self._sink = None
        self.failure = None

    def append(self, raw: bytes) -> None:
        """Hand received octets to the sink, if there is one."""
        sink = self._sink
        if sink is None:
            return
        try:
            sink.append(raw)
        except JournalWriteError as error:
            self._take_off(sink, error)

    def note(self, kind: str, data: Mapping[str, Any]) -> None:  # JSON values
        """Hand a remark to the sink, if there is one."""
        sink = self._sink
        if sink is None:
            return
        try:
            sink.note(kind, data)
        except JournalWriteError as error:
            self._take_off(sink, error)

    def _take_off(self, sink: RecordSink, error: JournalWriteError) -> None:
        if self._sink is sink:  # else it was detached, and closed, while it was writing
            self._sink, self.failure = None, error
