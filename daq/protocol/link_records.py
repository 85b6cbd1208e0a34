"""What the host's side of the link hands out: sorted input, timeouts, counters."""

from dataclasses import dataclass, field

from daq.protocol.message import Command, Reply
from daq.protocol.reports import Event, Status


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkTimeout:
    """A command that was given up: it may or may not have been executed."""

    ticket: int
    command: Command
    tries: int


@dataclass(slots=True, kw_only=True)
class LinkInput:
    """What one piece of received octets contained, each list in order of arrival.

    Attributes:
        streams: Messages for `StreamAssembler.feed`: stream frames, and the replies it reads.
        replies: Replies to submitted commands, with their tickets.
        events: Events not seen before; the link acknowledges them by itself.
        statuses: Status reports.
    """

    streams: list[bytes] = field(default_factory=list)
    replies: list[tuple[int, Reply]] = field(default_factory=list)
    events: list[Event] = field(default_factory=list)
    statuses: list[Status] = field(default_factory=list)


@dataclass(slots=True, kw_only=True)
class HostLinkCounters:
    """What the link has seen; the numbers only go up.

    Attributes:
        commands: Commands sent for the first time.
        retries: Commands sent again.
        timeouts: Commands given up.
        replies: Replies that matched a command under way.
        late_replies: Replies that matched none: repeated, or after giving up.
        repeated_events: Events that had been delivered before.
        malformed: Frames with a good CRC that are no message of this protocol.
        unexpected: Messages that only a host may send.
    """

    commands: int = 0
    retries: int = 0
    timeouts: int = 0
    replies: int = 0
    late_replies: int = 0
    repeated_events: int = 0
    malformed: int = 0
    unexpected: int = 0
