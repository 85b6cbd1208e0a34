"""The line's rate: asked for by SET_BAUD, in force once the reply has left, given up without a PING."""

from daq.protocol.codes import StatusCode

START_BAUD = 115_200
BAUDS = (115_200, 230_400, 460_800, 937_500, 1_171_875, 1_562_500, 2_343_750)
"""What the SCI's integer divider makes of 37.5 MHz to within 2 %; 921600 is 937500 on this part."""
REVERT_S = 0.5


class BaudSwitch:
    """The rate in force and the one before it, until a PING proves that the host has followed.

    Args:
        tick_hz: ticks per second.
    """

    def __init__(self, tick_hz: int) -> None:
        self.baud = START_BAUD
        self.revert_ticks = round(REVERT_S * tick_hz)
        self._proven_baud = START_BAUD
        self._revert_time: int | None = None

    def request(self, baud: int, time: int) -> StatusCode:
        """Change the rate; the transmitter follows when it has sent what was queued before."""
        if baud not in BAUDS:
            return StatusCode.OUT_OF_RANGE
        self.baud = baud
        self._revert_time = time + self.revert_ticks
        return StatusCode.OK

    def confirm(self) -> None:
        """Keep the rate: a PING has come through."""
        self._proven_baud = self.baud
        self._revert_time = None

    def ticks_left(self, time: int) -> int | None:
        """Return the ticks until the rate reverts; None while it is proven."""
        return None if self._revert_time is None else max(0, self._revert_time - time)

    def revert_if_due(self, time: int) -> bool:
        """Go back to the proven rate when no PING came in time; return whether that happened."""
        if self._revert_time is None or time < self._revert_time:
            return False
        self.baud = self._proven_baud
        self._revert_time = None
        return True
