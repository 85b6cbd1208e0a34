"""The one thread that owns the port: it alone reads and writes, journals, matches replies and finds a lost port again.

Theory of operation. Each turn writes what waits, sleeps in the port's read until octets come (or a request wakes it),
hands them to the journal, decodes them, and passes on: stream frames into a bounded queue, replies to whoever
asked, events and states to the rig's properties. It never sends a keep-alive by itself: those come from the task that
handles the data, so that a stuck task lets the drive's lease expire.

A lost port (cable pulled, adapter reset, controller restarted) fails what was being asked, and is looked for until
`reconnect_s` is over. The drive is never armed again by itself.
"""

import logging
import threading
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import replace

from daq.driver.conversation import Clock, Conversation, describe_silence
from daq.driver.frame_queue import FrameQueue
from daq.driver.handshake import Connection, Handshake
from daq.driver.monitor import LinkMonitor, clock_note, statistics_note
from daq.driver.options import RigOptions
from daq.driver.sink import LINK_LOST_KIND
from daq.errors import DaqError, DictionaryError, LinkTimeoutError, PortError
from daq.protocol.codes import EventCode
from daq.protocol.commands import LinkStats, Ping
from daq.protocol.link_records import LinkInput
from daq.protocol.message import Command, Reply
from daq.protocol.replies import LinkStatsReply, PingReply
from daq.protocol.reports import Event, Status
from daq.protocol.stream import LINK_LOST

_LOG = logging.getLogger(__name__)
_NS_PER_S = 1_000_000_000
_RETRY_S = 0.1
_SILENCE_NS = 1_500_000_000
_MAX_EVENTS = 1000
Handler = Callable[[Reply | DaqError, int], None]
"""Gets the reply, or why there is none, and the host time of it, ns; runs in the port thread, so it must not wait."""


class PortThread:
    """Owner of one port from `start` to `close`.

    Args:
        connection: The controller, already introduced.
        handshake: How to introduce it again after the port was lost.
        options: Queue length, gathering, time to look for a lost port.
        clock_ns: Host monotonic clock, ns.
    """

    def __init__(
        self, connection: Connection, handshake: Handshake, options: RigOptions, clock_ns: Clock
    ) -> None:
        self.connection = connection
        self.tap = connection.conversation.tap
        self.frames = FrameQueue(options.queue_frames)
        self.monitor = LinkMonitor(connection.hello.tick_hz, connection.baud, clock_ns())
        self.status: Status | None = None
        self.failure: DaqError | None = None
        self.link_up = True
        self.reboots = 0
        self.samples_lost = 0
        self._events: deque[Event] = deque(maxlen=_MAX_EVENTS)
        self._handshake = handshake
        self._options = options
        self._clock_ns = clock_ns
        self._requests: deque[tuple[Command, Handler]] = deque()
        self._handlers: dict[int, Handler] = {}
        self._lock = threading.Lock()
        self._stopping = threading.Event()
        self._next_record_ns = clock_ns()
        self._last_frame_ns = clock_ns()
        self._ping_lost = False
        self._thread = threading.Thread(target=self._run, name="jointscope-port", daemon=True)

    def start(self) -> None:
        """Begin to own the port."""
        self._thread.start()

    def close(self) -> None:
        """Give the port back; returns when the thread has ended."""
        self._stopping.set()
        with self._lock:
            self._conversation.transport.wake()
        if self._thread.is_alive():
            self._thread.join()

    def post(self, command: Command, handler: Handler) -> None:
        """Have a command sent; `handler` gets what comes of it. Callable from any thread.

        Raises:
            DaqError: The port is lost.
        """
        with self._lock:
            if self.failure is not None:
                raise self.failure
            if not self.link_up:
                raise PortError("the link to the controller is lost; wait until it is found again")
            self._requests.append((command, handler))
            self._conversation.transport.wake()

    def ask(self, command: Command) -> Reply:
        """Send a command and wait for its reply; retries and the time limit are the link's. Callable from any thread.

        Raises:
            LinkTimeoutError: No reply after the last try.
            PortError: The port was lost.
        """
        future: Future[Reply] = Future()

        def settle(outcome: Reply | DaqError, t_ns: int) -> None:
            if isinstance(outcome, DaqError):
                future.set_exception(outcome)
            else:
                future.set_result(outcome)

        self.post(command, settle)
        return future.result()

    def take_events(self) -> list[Event]:
        """Return the events since the last call."""
        events = []
        while self._events:
            events.append(self._events.popleft())
        return events

    @property
    def _conversation(self) -> Conversation:
        return self.connection.conversation

    def _run(self) -> None:
        try:
            self._hear_overheard()
            while not self._stopping.is_set():
                try:
                    self._turn()
                except PortError as error:
                    self._recover(error)
            self._fail(PortError("the rig was closed"))
        except DaqError as error:
            self._fail(error)
        except Exception as error:  # noqa: BLE001  # outermost loop: no caller may be left waiting for ever
            _LOG.exception("port thread failed")
            self._fail(DaqError(f"the port thread failed: {error!r}; this is an error of the program"))
        finally:
            self._conversation.close()

    def _turn(self) -> None:
        conversation, link = self._conversation, self._conversation.link
        while self._requests:
            command, handler = self._requests.popleft()
            self._submit(command, handler)
        # Somebody who waits for a reply should not wait for the rest of a frame as well.
        found, t_ns = conversation.turn(0.0 if self._handlers else self._options.gather_s)
        self.monitor.note_turn(t_ns)
        self._hear(found, t_ns)
        for lost in link.poll(t_ns):
            silence = LinkTimeoutError(describe_silence(lost.command, lost.tries))
            self._handlers.pop(lost.ticket, _ignore)(silence, t_ns)
        if t_ns >= self._next_record_ns:
            self._record_second(t_ns)

    def _submit(self, command: Command, handler: Handler) -> None:
        try:
            ticket = self._conversation.link.submit(command, self._clock_ns())
        except ValueError as error:
            handler(DaqError(f"{type(command).__name__} cannot be sent: {error}"), self._clock_ns())
            return
        self._handlers[ticket] = handler

    def _hear_overheard(self) -> None:
        overheard, self._conversation.overheard = self._conversation.overheard, []
        for found in overheard:
            self._hear(found, self._clock_ns())

    def _hear(self, found: LinkInput, t_ns: int) -> None:
        if found.streams:
            self.frames.put(found.streams)
            self._last_frame_ns = t_ns
        if found.statuses:
            self.status = found.statuses[-1]
            self._last_frame_ns = t_ns
        for ticket, reply in found.replies:
            self._last_frame_ns = t_ns
            self._handlers.pop(ticket, _ignore)(reply, t_ns)
        if found.events:
            self._events.extend(found.events)
            self.frames.poke()
            for event in found.events:
                if self._options.on_event is not None:
                    self._options.on_event(event)
                if event.code == EventCode.BOOT and event.arg != self.connection.hello.session:
                    raise PortError("the controller has restarted")

    def _record_second(self, t_ns: int) -> None:
        self._next_record_ns = t_ns + _NS_PER_S
        if self._ping_lost and t_ns - self._last_frame_ns > _SILENCE_NS:
            raise PortError("the controller has fallen silent, or talks at another rate")
        self._submit(Ping(cookie=t_ns & 0xFFFFFFFF), self._note_ping(self._clock_ns()))
        self._submit(LinkStats(), self._note_controller)
        self.monitor.count(self._conversation.link)
        record = self.monitor.complete(
            t_ns, samples_lost=self.samples_lost, queue_dropped_frames=self.frames.dropped_frames
        )
        self.tap.note("link_statistics", statistics_note(record))
        if record.clock is not None:
            self.tap.note("clock_fit", clock_note(record.clock))

    def _note_ping(self, t_sent_ns: int) -> Handler:
        def handle(outcome: Reply | DaqError, t_ns: int) -> None:
            self._ping_lost = isinstance(outcome, DaqError)
            if isinstance(outcome, PingReply):
                self.monitor.note_ping(outcome, t_sent_ns, t_ns)

        return handle

    def _note_controller(self, outcome: Reply | DaqError, t_ns: int) -> None:
        if isinstance(outcome, LinkStatsReply):
            self.monitor.note_controller(outcome)

    def _recover(self, error: PortError) -> None:
        """Look for the lost port until it is found, the time is over, or the rig is closed."""
        with self._lock:
            self.link_up = False
            self._conversation.close()
        lost_ns = self._clock_ns()
        _LOG.warning("link lost: %s", error)
        self.monitor.count(self._conversation.link)
        self.tap.note(LINK_LOST_KIND, {"t_ns": lost_ns, "cause": str(error)})
        self.frames.put([LINK_LOST])
        self._give_up_requests(PortError(f"link lost: {error}"))
        while not self._stopping.wait(_RETRY_S):
            try:
                connection = self._handshake.connect(self.connection.baud, self.tap)
            except (PortError, LinkTimeoutError) as again:
                if self._clock_ns() - lost_ns > self._options.reconnect_s * _NS_PER_S:
                    raise PortError(
                        f"link lost ({error}) and not found again in {self._options.reconnect_s:g} s: {again}"
                    ) from error
            else:
                self._adopt(connection, lost_ns)
                return

    def _adopt(self, connection: Connection, lost_ns: int) -> None:
        old = self.connection
        if connection.hello.dictionary_crc != old.hello.dictionary_crc:
            connection.conversation.close()
            raise DictionaryError(
                "another controller, or another program, answers at this port now; open it anew"
            )
        rebooted = connection.hello.session != old.hello.session
        with self._lock:
            self.connection = replace(connection, warnings=old.warnings + connection.warnings)
            self.link_up = True
        self.reboots += rebooted
        self.monitor.note_reconnect(connection.baud, rebooted=rebooted)
        t_ns = self._clock_ns()
        self._last_frame_ns, self._next_record_ns, self._ping_lost = t_ns, t_ns, False
        self.tap.note(
            "link_found", {"t_ns": t_ns, "lost_for_s": (t_ns - lost_ns) / _NS_PER_S, "rebooted": rebooted}
        )
        self._hear_overheard()

    def _give_up_requests(self, error: DaqError) -> None:
        waiting = [handler for _, handler in self._requests] + list(self._handlers.values())
        self._requests.clear()
        self._handlers.clear()
        for handler in waiting:
            handler(error, self._clock_ns())

    def _fail(self, error: DaqError) -> None:
        with self._lock:
            self.failure = error
            self.link_up = False
        self._give_up_requests(error)
        self.frames.poke()


def _ignore(outcome: Reply | DaqError, t_ns: int) -> None:
    """Take what nobody waits for: a reply to a request that was given up."""
