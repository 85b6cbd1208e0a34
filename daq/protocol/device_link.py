"""The controller's side of the link: each command handed out once, repetitions answered from memory.

The counterpart of `host_link.py`, for the emulated controller and as the model for a real one. It holds the
rules of docs/protocol.md, "Link": nothing but HELLO and ESTOP before a session is open, no command executed
twice, no more octets held than credits given, the short refusal for what cannot be understood. What a
command means is the program's business; so are events and their repetition, whose time it knows.
"""

from collections import deque
from dataclasses import dataclass

from daq.errors import FrameError
from daq.protocol.codes import StatusCode
from daq.protocol.commands import Estop, Hello
from daq.protocol.framing import FRAME_OVERHEAD_OCTETS, MAX_WIRE_OCTETS, FrameDecoder, encode_frame
from daq.protocol.message import REPLY_BIT, Command, Reply, Report
from daq.protocol.messages import MESSAGES, decode_message, encode_message
from daq.protocol.replies import HelloReply, Refusal, StreamStartReply
from daq.protocol.reports import Stream
from daq.protocol.sequence import WINDOW, Freshness, SequenceWindow


@dataclass(slots=True, kw_only=True)
class DeviceLinkCounters:
    """What the link has seen since boot; the numbers only go up. LINK_STATS reports them.

    Attributes:
        rx_malformed: Frames with a good CRC whose fields or length are wrong.
        rx_unknown: Frames of a type that is no command.
        rx_overruns: Commands refused because the host sent more than its credits.
        rx_repeated: Commands received again; answered from memory or passed over, never executed again.
        tx_frames: Frames made.
        tx_octets: Octets of these frames.
    """

    rx_malformed: int = 0
    rx_unknown: int = 0
    rx_overruns: int = 0
    rx_repeated: int = 0
    tx_frames: int = 0
    tx_octets: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class _Answered:
    seq: int
    command: bytes
    frame: bytes


class DeviceLink:
    """Controller's end of the link; a new one for each boot.

    Args:
        rx_credits: Octets of commands that may await their reply, as announced in HELLO; at least 256.
    """

    def __init__(self, rx_credits: int = 512) -> None:
        if rx_credits < MAX_WIRE_OCTETS:
            raise ValueError(f"rx_credits={rx_credits} must be at least {MAX_WIRE_OCTETS}, one longest frame")
        self.counters = DeviceLinkCounters()
        self.decoder = FrameDecoder()
        self.rx_credits = rx_credits
        self._window: SequenceWindow | None = None
        self._greeted = False
        self._pending: dict[int, bytes] = {}
        self._answered: deque[_Answered] = deque(maxlen=WINDOW)
        self._report_seqs: dict[int, int] = {}
        self._frames: list[bytes] = []

    @property
    def credits_free(self) -> int:
        """Octets that the host may send now; STATUS reports it."""
        held = sum(len(body) + FRAME_OVERHEAD_OCTETS for body in self._pending.values())
        return self.rx_credits - held

    def receive(self, data: bytes) -> list[tuple[int, Command]]:
        """Take received octets, in pieces of any size; return the commands to execute, each exactly once."""
        commands = []
        for body in self.decoder.feed(data):
            command = self._understand(body)
            if command is not None and self._admit(body, command):
                commands.append((body[1], command))
        return commands

    def reply(self, seq: int, reply: Reply) -> None:
        """Answer the command that `receive` gave out with `seq`, and keep the answer for its repetitions."""
        frame = encode_frame(encode_message(seq, reply))
        if _answers(reply, Estop):
            self._queue_frame(frame)
            return
        command = self._pending.pop(seq, None)
        if command is None:
            return  # a HELLO has come in between: nobody waits for this reply any more
        if isinstance(reply, HelloReply) and reply.status == StatusCode.OK:
            self._greeted = True
        if isinstance(reply, StreamStartReply) and reply.status == StatusCode.OK:
            self._report_seqs[Stream.TYPE] = 0
        self._answered.append(_Answered(seq=seq, command=command, frame=frame))
        self._queue_frame(frame)

    def send(self, report: Report) -> None:
        """Send a report; reports of each type are numbered on their own."""
        seq = self._report_seqs.get(report.TYPE, 0)
        self._report_seqs[report.TYPE] = (seq + 1) & 0xFF
        self._queue_frame(encode_frame(encode_message(seq, report)))

    def take_frames(self) -> list[bytes]:
        """Return the frames made since the last call, for a transmitter that drops whole frames."""
        frames, self._frames = self._frames, []
        return frames

    def take_output(self) -> bytes:
        """Return the octets of the frames made since the last call."""
        return b"".join(self.take_frames())

    def _understand(self, body: bytes) -> Command | None:
        """Decode a command; refuse, in the short form, what is none."""
        try:
            _, message = decode_message(body)
        except FrameError:
            known = body[0] in MESSAGES
            self.counters.rx_malformed += known
            self.counters.rx_unknown += not known
            if body[0] < REPLY_BIT:
                status = StatusCode.MALFORMED if known else StatusCode.UNKNOWN_COMMAND
                self._refuse(body, status)
            return None
        if not isinstance(message, Command):
            self.counters.rx_unknown += 1
            return None
        return message

    def _admit(self, body: bytes, command: Command) -> bool:
        """Decide whether a command is to be executed now; if not, answer it where an answer is due."""
        if isinstance(command, Estop):
            return True
        if isinstance(command, Hello):
            return self._admit_hello(body)
        if self._window is None or not self._greeted:
            self._refuse(body, StatusCode.WRONG_SESSION)
            return False
        if self._window.judge(body[1]) is not Freshness.NEW:
            self._repeat_answer(body)
            return False
        self._window.accept(body[1])
        overrun = len(body) + FRAME_OVERHEAD_OCTETS > self.credits_free
        self._pending[body[1]] = body
        if overrun:
            self.counters.rx_overruns += 1
            self.reply(body[1], Refusal(command=command.TYPE, status=StatusCode.NO_CREDIT))
        return not overrun

    def _admit_hello(self, body: bytes) -> bool:
        if body in self._pending.values() or any(answered.command == body for answered in self._answered):
            self._repeat_answer(body)
            return False
        self._window = SequenceWindow(body[1])
        self._pending = {body[1]: body}
        self._answered.clear()
        return True

    def _repeat_answer(self, body: bytes) -> None:
        self.counters.rx_repeated += 1
        for answered in self._answered:
            if answered.command == body:
                self._queue_frame(answered.frame)

    def _refuse(self, body: bytes, status: StatusCode) -> None:
        self._queue_frame(encode_frame(encode_message(body[1], Refusal(command=body[0], status=status))))

    def _queue_frame(self, frame: bytes) -> None:
        self.counters.tx_frames += 1
        self.counters.tx_octets += len(frame)
        self._frames.append(frame)


def _answers(reply: Reply, command: type[Command]) -> bool:
    """Tell whether `reply` is one to `command`, in its full or its short form."""
    if isinstance(reply, Refusal):
        return reply.command == command.TYPE
    return reply.TYPE == command.TYPE | REPLY_BIT
