"""What the serial line loses on the controller's side: counted by the line, reported by the program."""

from dataclasses import dataclass


@dataclass(slots=True)
class LineCounters:
    """Losses since power-on; counters only go up.

    Attributes:
        tx_drops: frames for which the transmit ring had no room.
        tx_dropped_octets: their octets.
        rx_overruns: octets that came while the receive buffer was full.
    """

    tx_drops: int = 0
    tx_dropped_octets: int = 0
    rx_overruns: int = 0
