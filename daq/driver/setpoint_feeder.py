"""Streams set-points: keeps the controller's two halves filled while it plays them.

Theory of operation. The controller plays one half of its buffer while the host fills the other; a half is free
again when its last word has been played. How many words were played follows from the stream's ticks, which lag a
little behind, so the estimate is never too high and a chunk is never refused for want of room. The words
end in two halves of zeros, in which the host ends the stream: the last value is so followed by rest, not by an
underrun.
"""

import numpy as np

from daq.driver.handshake import expect
from daq.driver.parameters import Ask
from daq.excitation.spec import Setpoints
from daq.excitation.waveform import to_words
from daq.protocol.codes import SetpointFlag
from daq.protocol.commands import Ping, RunAbort, SetpointBegin, SetpointChunk
from daq.protocol.dictionary_entries import SetpointBuffer
from daq.protocol.replies import PingReply, SetpointBeginReply, SetpointChunkReply

CHUNK_WORDS = 96
"""Most words a chunk; one of less than about a quarter of it is not worth its frame."""
MIN_CHUNK_WORDS = 25


class SetpointFeeder:
    """One stream of set-points, from `begin` until all of it was sent.

    Args:
        setpoints: What is played.
        tick_hz: Controller ticks per second.
        buffer: Size of the controller's halves.
        ask: How to reach the controller.
    """

    def __init__(self, setpoints: Setpoints, tick_hz: int, buffer: SetpointBuffer, ask: Ask) -> None:
        self._ask = ask
        self._hold_ticks = setpoints.hold_ticks(tick_hz)
        self._half = buffer.half_words
        self._room = buffer.half_words * buffer.halves
        words = np.concatenate((to_words(setpoints.values_a), np.zeros(self._room, dtype=np.int16)))
        self._octets = words.astype("<i2").tobytes()
        self._length = words.size
        self._sent = 0
        self._values = len(setpoints.values_a)
        self._start_tick = 0
        self._ended = False

    def begin(self, *, centring: bool) -> int:
        """Open the stream, fill both halves, which starts the play, and return the tick of the first value.

        The tick is taken just after the start, so it is late by one round trip at most: a feeder that believes
        too few words to be played sends a chunk a little later, never too early.

        Raises:
            DeviceRefusedError: Drive not armed, or a value beyond the controller's current limit.
        """
        flags = int(SetpointFlag.CENTRING) if centring else 0
        expect(self._ask(SetpointBegin(divisor=self._hold_ticks, flags=flags), ""), SetpointBeginReply)
        self._send(self._room)
        self._start_tick = expect(self._ask(Ping(cookie=0), ""), PingReply).tick
        return self._start_tick

    def feed(self, tick: int) -> None:
        """Send what there is room for at `tick` (the newest one received); end the stream when all is played."""
        elapsed = (tick - self._start_tick + (1 << 31)) % (1 << 32) - (1 << 31)
        played = max(0, elapsed) // self._hold_ticks
        if played >= self._values and not self._ended:
            self._ended = True
            self._ask(RunAbort(), "")
        if self._ended or self._sent == self._length:
            return
        free = played // self._half * self._half + self._room - self._sent
        if free >= MIN_CHUNK_WORDS:
            self._send(free)

    def _send(self, free: int) -> None:
        stop = min(self._sent + free, self._length)
        while self._sent < stop:
            end = min(self._sent + CHUNK_WORDS, stop)
            chunk = SetpointChunk(first=self._sent, words=self._octets[2 * self._sent : 2 * end])
            expect(self._ask(chunk, f"words {self._sent} to {end - 1}"), SetpointChunkReply)
            self._sent = end
