"""The host's side of the link: commands out, replies matched, repeated, given up; docs/protocol.md, "Link".

Theory of operation. At most `WINDOW` commands are under way, and never one whose sequence number is
`WINDOW` or more after the oldest unanswered one; so the controller need only remember its last `WINDOW`
replies to answer a repeated command without executing it twice. Beside that the octets under way never
exceed the controller's credits. What may not be sent yet waits in a queue. ESTOP passes by all of this: it
goes out at once, three times over.

Bytes in, messages out: the caller brings the octets and the time, and carries the output to the port. One
thread at a time may use an instance.
"""

from collections import deque
from dataclasses import dataclass

from daq.errors import FrameError
from daq.protocol.codes import EventCode, StatusCode
from daq.protocol.commands import Estop, EventAck, Hello
from daq.protocol.framing import FRAME_OVERHEAD_OCTETS, MAX_WIRE_OCTETS, FrameDecoder, encode_frame
from daq.protocol.link_records import HostLinkCounters, LinkInput, LinkTimeout
from daq.protocol.message import REPLY_BIT, Command, Reply
from daq.protocol.messages import decode_message, encode_message
from daq.protocol.replies import HelloReply, Refusal
from daq.protocol.reports import Event, Status, Stream
from daq.protocol.round_trip import LinkOptions, RoundTripTimer
from daq.protocol.sequence import WINDOW
from daq.protocol.stream import STREAM_TYPES

ESTOP_COPIES = 3
"""Sent back to back, so that one burst of noise does not swallow the stop."""

RECENT_EVENTS = 64
"""Event numbers kept to tell a repetition from a new event; a controller has far fewer waiting."""


@dataclass(slots=True, kw_only=True, eq=False)
class _Pending:
    """A command on its way from submission to reply."""

    ticket: int
    command: Command
    message: bytes  # without sequence number: that is allotted when it is sent
    seq: int = 0
    frame: bytes = b""
    tries: int = 0
    sent_ns: int = 0
    deadline_ns: int = 0


class HostLink:
    """Host's end of one connection; make a new one for each time the port is opened.

    Args:
        options: Waiting times and number of tries.
    """

    def __init__(self, options: LinkOptions | None = None) -> None:
        self._options = options or LinkOptions()
        self.counters = HostLinkCounters()
        self.decoder = FrameDecoder()
        self.timer = RoundTripTimer(self._options)
        self._credits = MAX_WIRE_OCTETS  # every controller has room for one longest frame; HELLO tells more
        self._next_seq = self._options.first_seq
        self._next_ticket = 0
        self._queue: deque[_Pending] = deque()
        self._under_way: dict[int, _Pending] = {}  # by sequence number, oldest first
        self._estops: list[_Pending] = []
        self._acks: set[int] = set()  # tickets of acknowledgements, which the link submits for itself
        self._recent_events: deque[int] = deque(maxlen=RECENT_EVENTS)
        self._session: int | None = None
        self._output = bytearray()

    @property
    def octets_under_way(self) -> int:
        """Octets of commands sent and not yet answered; never more than the controller's credits."""
        return sum(len(pending.frame) for pending in self._under_way.values())

    @property
    def next_deadline_ns(self) -> int | None:
        """When `poll` has something to do, None while nothing is under way."""
        return min((p.deadline_ns for p in (*self._under_way.values(), *self._estops)), default=None)

    def submit(self, command: Command, t_ns: int) -> int:
        """Queue a command and send what may be sent.

        Returns:
            A ticket that the reply or the timeout will carry.

        Raises:
            ValueError: A field is out of range, or the message is too long for a frame.
        """
        message = encode_message(0, command)
        encode_frame(message)  # refuse a message that is too long here, where the caller sees it
        pending = _Pending(ticket=self._next_ticket, command=command, message=message)
        self._next_ticket += 1
        if isinstance(command, Estop):
            self._estops.append(pending)
            self._send(pending, t_ns, copies=ESTOP_COPIES)
        else:
            self._queue.append(pending)
            self._send_queued(t_ns)
        return pending.ticket

    def receive(self, data: bytes, t_ns: int) -> LinkInput:
        """Take received octets, in pieces of any size."""
        found = LinkInput()
        for body in self.decoder.feed(data):
            if body[0] in STREAM_TYPES:
                found.streams.append(body)
            if body[0] != Stream.TYPE:
                self._take_message(body, t_ns, found)
        self._send_queued(t_ns)
        return found

    def poll(self, t_ns: int) -> list[LinkTimeout]:
        """Repeat the commands whose reply is overdue; return those that were given up."""
        given_up = []
        for pending in (*self._under_way.values(), *self._estops):
            if pending.deadline_ns > t_ns:
                continue
            if pending.tries < self._options.tries:
                self.counters.retries += 1
                self._transmit(pending, t_ns)
            else:
                given_up.append(pending)
        for pending in given_up:
            self._forget(pending)
        self.counters.timeouts += len(given_up)
        self._send_queued(t_ns)
        return [
            LinkTimeout(ticket=pending.ticket, command=pending.command, tries=pending.tries)
            for pending in given_up
            if not self._is_own(pending)
        ]

    def take_output(self) -> bytes:
        """Return the octets to be written to the port since the last call."""
        output = bytes(self._output)
        self._output.clear()
        return output

    def _send_queued(self, t_ns: int) -> None:
        while self._queue and self._may_send(self._queue[0]):
            pending = self._queue.popleft()
            pending.seq = self._next_seq
            self._under_way[pending.seq] = pending
            self._send(pending, t_ns)
            self._next_seq = (self._next_seq + 1) & 0xFF

    def _may_send(self, pending: _Pending) -> bool:
        if not self._under_way:
            return True
        oldest = next(iter(self._under_way))
        octets = len(pending.message) + FRAME_OVERHEAD_OCTETS
        return (self._next_seq - oldest) & 0xFF < WINDOW and self.octets_under_way + octets <= self._credits

    def _send(self, pending: _Pending, t_ns: int, copies: int = 1) -> None:
        pending.frame = encode_frame(bytes((pending.message[0], pending.seq)) + pending.message[2:])
        pending.sent_ns = t_ns
        self.counters.commands += 1
        self._output += pending.frame * (copies - 1)
        self._transmit(pending, t_ns)

    def _transmit(self, pending: _Pending, t_ns: int) -> None:
        pending.tries += 1
        pending.deadline_ns = t_ns + self.timer.wait_ns(pending.tries)
        self._output += pending.frame

    def _forget(self, pending: _Pending) -> None:
        if pending in self._estops:
            self._estops.remove(pending)
        else:
            del self._under_way[pending.seq]

    def _is_own(self, pending: _Pending) -> bool:
        """Tell whether the link submitted this command for itself; to be asked once, at its end."""
        own = pending.ticket in self._acks
        self._acks.discard(pending.ticket)
        return own

    def _take_message(self, body: bytes, t_ns: int, found: LinkInput) -> None:
        try:
            seq, message = decode_message(body)
        except FrameError:
            self.counters.malformed += 1
            return
        match message:
            case Reply():
                self._take_reply(seq, message, t_ns, found)
            case Event():
                self._take_event(message, t_ns, found)
            case Status():
                found.statuses.append(message)
            case _:
                self.counters.unexpected += 1

    def _take_reply(self, seq: int, reply: Reply, t_ns: int, found: LinkInput) -> None:
        answered = self._match(seq, reply)
        if not answered:
            self.counters.late_replies += 1
            return
        if isinstance(reply, HelloReply) and reply.status == StatusCode.OK:
            self._open_session(reply)
        self.counters.replies += 1
        for pending in answered:
            if pending.tries == 1:
                self.timer.observe(t_ns - pending.sent_ns)
            self._forget(pending)
            if not self._is_own(pending):
                found.replies.append((pending.ticket, reply))

    def _match(self, seq: int, reply: Reply) -> list[_Pending]:
        """Return what `reply` answers: one command; for ESTOP, every one not yet answered."""
        command_type = reply.command if isinstance(reply, Refusal) else reply.TYPE & ~REPLY_BIT
        if command_type == Estop.TYPE:
            return list(self._estops)
        pending = self._under_way.get(seq)
        if pending is None or command_type != pending.command.TYPE:
            return []
        if isinstance(reply, HelloReply) and isinstance(pending.command, Hello):
            return [pending] if reply.cookie == pending.command.cookie else []
        return [pending]

    def _open_session(self, hello: HelloReply) -> None:
        self._credits = max(hello.rx_credits, MAX_WIRE_OCTETS)
        if self._session not in (None, hello.session):
            self._recent_events.clear()
        self._session = hello.session

    def _take_event(self, event: Event, t_ns: int, found: LinkInput) -> None:
        if event.code == EventCode.BOOT and self._session not in (None, event.arg):
            self._recent_events.clear()  # a restarted controller numbers its events anew ...
            self._session = None  # ... and refuses everything until HELLO
        if event.event in self._recent_events:
            self.counters.repeated_events += 1
        else:
            self._recent_events.append(event.event)
            found.events.append(event)
        if self._session is not None and not self._is_acknowledging(event.event):
            self._acks.add(self.submit(EventAck(event=event.event), t_ns))

    def _is_acknowledging(self, event: int) -> bool:
        return any(
            isinstance(pending.command, EventAck) and pending.command.event == event
            for pending in (*self._under_way.values(), *self._queue)
        )
