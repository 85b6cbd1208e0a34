"""Events waiting for the host's acknowledgement, each repeated every 100 ms until it comes."""

from dataclasses import dataclass

from daq.protocol.codes import EventCode
from daq.protocol.reports import Event

REPEAT_S = 0.1
MAX_OUTSTANDING = 8
"""Beyond this the oldest is given up: a host that acknowledges nothing must not fill the line."""


@dataclass(slots=True)
class _Outstanding:
    event: Event
    next_time: int


class EventBox:
    """The controller's list of events that nobody has acknowledged yet.

    Args:
        tick_hz: ticks per second.
    """

    def __init__(self, tick_hz: int) -> None:
        self._repeat_ticks = round(REPEAT_S * tick_hz)
        self._outstanding: list[_Outstanding] = []
        self._next_id = 1

    def post(self, code: EventCode, time: int, tick: int, arg: int = 0) -> None:
        """Add an event that happened at the visible `tick`, due for sending at once."""
        event = Event(event=self._next_id, code=code, tick=tick, arg=arg)
        self._next_id = self._next_id % 0xFFFF + 1
        self._outstanding.append(_Outstanding(event, time))
        del self._outstanding[:-MAX_OUTSTANDING]

    def acknowledge(self, event_id: int) -> None:
        """Stop repeating an event; an unknown id is one that was acknowledged before."""
        self._outstanding = [entry for entry in self._outstanding if entry.event.event != event_id]

    def due(self, time: int) -> list[Event]:
        """Return the events to be sent at `time` and set the time of their next repetition."""
        events = []
        for entry in self._outstanding:
            if entry.next_time <= time:
                entry.next_time = time + self._repeat_ticks
                events.append(entry.event)
        return events

    def next_time(self) -> int | None:
        """Return the time at which something is due; None if nothing waits."""
        return min((entry.next_time for entry in self._outstanding), default=None)
