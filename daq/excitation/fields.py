"""From SI values to the integers of a RUN command, each with its range."""

from dataclasses import dataclass

from daq.protocol.codes import Generator


@dataclass(frozen=True, slots=True, kw_only=True)
class GeneratorFields:
    """The fields of a RUN command whose meaning depends on the generator (docs/protocol.md, "Generators")."""

    generator: Generator
    period_ticks: int = 0
    phase: int = 0
    p1: int = 0
    p2: int = 0
    p3: int = 0
    p4: int = 0


def to_integer(name: str, value: float, scale: float, allowed: tuple[int, int]) -> int:
    """Return `value` * `scale` rounded to an integer.

    Args:
        name: What the value is called, for the message.
        value: Value in SI.
        scale: Integers per SI unit.
        allowed: Smallest and largest integer that the wire field takes.

    Raises:
        ValueError: The value is not finite or outside the range; the message gives the range in SI.
    """
    low, high = allowed
    scaled = value * scale
    if not low - 0.5 <= scaled <= high + 0.5:  # also false for NaN
        raise ValueError(f"{name}={value:g} must lie in [{low / scale:g}, {high / scale:g}]")
    return min(max(round(scaled), low), high)


def frequency_uhz(name: str, frequency_hz: float, tick_hz: int) -> int:
    """Return a frequency in uHz, at most a quarter of the tick rate."""
    return to_integer(name, frequency_hz, 1e6, (1, tick_hz * 1_000_000 // 4))


def phase_word(turns: float) -> int:
    """Return a phase in 1/65536 turn; any number of turns is folded into one."""
    return round(turns * 65536) % 65536
