"""What a rig is asked to play, in SI units, and the RUN command that says so on the wire.

Each class is one generator of docs/protocol.md, "Generators". Values go to the controller as integers (uA, ticks,
uHz); the waveform that the host predicts (`daq.excitation.waveform`) is computed from those integers, so that both
sides mean the same reference to within one count. Limits of the rig are not judged here but in `daq.excitation.check`.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass

from daq.excitation.fields import GeneratorFields, frequency_uhz, phase_word, to_integer
from daq.protocol.codes import ChirpMode, Generator, RunFlag, StaircaseMode
from daq.protocol.commands import Run


@dataclass(frozen=True, slots=True, kw_only=True)
class Excitation(ABC):
    """Abstract: an excitation that the controller generates itself.

    Attributes:
        amplitude_a: Peak of the shape, A.
        offset_a: Constant added to it, A.
        duration_s: Length of the run, s; 0 lets it end by itself (chirp, staircase, table) or never.
        ramp_s: Fade-in and fade-out, s.
        repeat: Repeat a generator that has a natural length until `duration_s` is over.
    """

    amplitude_a: float
    offset_a: float = 0.0
    duration_s: float = 0.0
    ramp_s: float = 0.0
    repeat: bool = False

    @abstractmethod
    def fields(self, tick_hz: int) -> GeneratorFields:
        """Return the generator's own fields of the RUN command.

        Raises:
            ValueError: A value lies outside what the generator can play.
        """

    def to_run_command(self, tick_hz: int, *, centring: bool = True, start_tick: int = 0) -> Run:
        """Return the RUN command.

        Args:
            tick_hz: Ticks per second, from HELLO.
            centring: Hold the joint's mean position by the controller's slow loop.
            start_tick: Controller tick of the first value; 0 starts at once.

        Raises:
            ValueError: A value lies outside what the generator can play.
        """
        own = self.fields(tick_hz)
        flags = (RunFlag.CENTRING if centring else RunFlag(0)) | (
            RunFlag.REPEAT if self.repeat else RunFlag(0)
        )
        return Run(
            generator=own.generator,
            flags=int(flags),
            amplitude_ua=to_integer("amplitude_a", self.amplitude_a, 1e6, (-(2**31), 2**31 - 1)),
            offset_ua=to_integer("offset_a", self.offset_a, 1e6, (-(2**31), 2**31 - 1)),
            period_ticks=own.period_ticks,
            duration_ticks=to_integer("duration_s", self.duration_s, tick_hz, (0, 2**31 - 1)),
            phase=own.phase,
            ramp_ticks=to_integer("ramp_s", self.ramp_s, tick_hz, (0, 65535)),
            p1=own.p1,
            p2=own.p2,
            p3=own.p3,
            p4=own.p4,
            start_tick=start_tick,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Sine(Excitation):
    """A sine of one period; `phase_turns` = 0.25 starts at its peak."""

    period_s: float
    phase_turns: float = 0.0

    def fields(self, tick_hz: int) -> GeneratorFields:
        """Return the fields of generator 1."""
        return GeneratorFields(
            generator=Generator.SINE,
            period_ticks=to_integer("period_s", self.period_s, tick_hz, (4, 2**32 - 1)),
            phase=phase_word(self.phase_turns),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Trapezoid(Excitation):
    """An odd trapezoid; `rise_fraction` is the way from -1 to +1 as a share of the period (0.5: a triangle)."""

    period_s: float
    rise_fraction: float
    phase_turns: float = 0.0

    def fields(self, tick_hz: int) -> GeneratorFields:
        """Return the fields of generator 2."""
        return GeneratorFields(
            generator=Generator.TRAPEZOID,
            period_ticks=to_integer("period_s", self.period_s, tick_hz, (4, 2**32 - 1)),
            phase=phase_word(self.phase_turns),
            p1=to_integer("rise_fraction", self.rise_fraction, 65536, (1, 32768)),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Chirp(Excitation):
    """A sweep from `start_hz` to `end_hz` in `sweep_s`."""

    sweep_s: float
    start_hz: float
    end_hz: float
    mode: ChirpMode = ChirpMode.LINEAR
    phase_turns: float = 0.0

    def fields(self, tick_hz: int) -> GeneratorFields:
        """Return the fields of generator 3."""
        return GeneratorFields(
            generator=Generator.CHIRP,
            period_ticks=to_integer("sweep_s", self.sweep_s, tick_hz, (16, 2**31 - 1)),
            phase=phase_word(self.phase_turns),
            p1=frequency_uhz("start_hz", self.start_hz, tick_hz),
            p2=frequency_uhz("end_hz", self.end_hz, tick_hz),
            p3=int(self.mode),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Prbs(Excitation):
    """A pseudo-random binary sequence of a shift register with `register_bits`, each bit held for `bit_s`."""

    register_bits: int
    bit_s: float
    seed: int = 1

    def fields(self, tick_hz: int) -> GeneratorFields:
        """Return the fields of generator 4."""
        if self.register_bits not in PRBS_TAPS:
            allowed = ", ".join(map(str, PRBS_TAPS))
            raise ValueError(
                f"register_bits={self.register_bits} has no polynomial here; use one of {allowed}"
            )
        mask = (1 << self.register_bits) - 1
        if not 0 < self.seed < 2**32 or not self.seed & mask:
            raise ValueError(
                f"seed={self.seed} must be a 32-bit number with one of its low {self.register_bits} bits set"
            )
        return GeneratorFields(
            generator=Generator.PRBS,
            p1=self.register_bits,
            p2=to_integer("bit_s", self.bit_s, tick_hz, (1, 2**32 - 1)),
            p3=self.seed,
        )


PRBS_TAPS = {5: 3, 6: 5, 7: 6, 9: 5, 10: 7, 11: 9, 15: 14, 17: 14, 18: 11, 20: 17, 23: 18, 31: 28}
"""Register length n -> second tap m of the polynomial x^n + x^m + 1 (docs/protocol.md, generator 4)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Staircase(Excitation):
    """`levels` equidistant levels between -amplitude and +amplitude, each held for `level_s`."""

    levels: int
    level_s: float
    mode: StaircaseMode = StaircaseMode.FROM_ZERO

    def fields(self, tick_hz: int) -> GeneratorFields:
        """Return the fields of generator 5."""
        if self.mode is StaircaseMode.FROM_ZERO and (self.levels < 3 or self.levels % 2 == 0):
            raise ValueError(
                f"levels={self.levels} must be odd and at least 3 to start from zero; use {self.levels + 1}"
            )
        return GeneratorFields(
            generator=Generator.STAIRCASE,
            p1=to_integer("levels", self.levels, 1, (2, 1024)),
            p2=to_integer("level_s", self.level_s, tick_hz, (1, 2**32 - 1)),
            p3=int(self.mode),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Multisine(Excitation):
    """A random-phase multisine of `lines` harmonics of 1 / `period_s`: `lowest`, `lowest` + `step`, ..."""

    period_s: float
    lines: int
    lowest: int = 1
    step: int = 1
    seed: int = 1
    phase_turns: float = 0.0

    def fields(self, tick_hz: int) -> GeneratorFields:
        """Return the fields of generator 6."""
        period_ticks = to_integer("period_s", self.period_s, tick_hz, (4, 2**32 - 1))
        lines = to_integer("lines", self.lines, 1, (1, 64))
        highest = self.lowest + (lines - 1) * self.step
        limit = min(1024, period_ticks // 4)
        if highest > limit:
            raise ValueError(
                f"highest harmonic {highest} exceeds {limit}; use fewer lines, a smaller step or a longer period"
            )
        return GeneratorFields(
            generator=Generator.MULTISINE,
            period_ticks=period_ticks,
            phase=phase_word(self.phase_turns),
            p1=lines,
            p2=to_integer("seed", self.seed, 1, (1, 2**32 - 1)),
            p3=to_integer("lowest", self.lowest, 1, (1, 1024)),
            p4=to_integer("step", self.step, 1, (1, 1024)),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Table(Excitation):
    """A table of currents that is uploaded first; `amplitude_a` scales it (1.0: as it is).

    Attributes:
        values_a: The currents, A, at most 1024.
        hold_s: Time each value is held, s.
        slot: Which of the controller's two tables to use.
    """

    values_a: tuple[float, ...]
    hold_s: float
    amplitude_a: float = 1.0
    slot: int = 0

    def fields(self, tick_hz: int) -> GeneratorFields:
        """Return the fields of generator 7."""
        to_integer("number of values_a", len(self.values_a), 1, (1, 1024))
        return GeneratorFields(
            generator=Generator.TABLE,
            p1=to_integer("slot", self.slot, 1, (0, 1)),
            p2=to_integer("hold_s", self.hold_s, tick_hz, (1, 2**32 - 1)),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Setpoints:
    """Currents streamed from the host while they are played: any length, any shape, but the host must keep up.

    Attributes:
        values_a: The currents, A.
        hold_s: Time each value is held, s.
    """

    values_a: tuple[float, ...]
    hold_s: float

    def hold_ticks(self, tick_hz: int) -> int:
        """Return how many ticks each value is held."""
        return to_integer("hold_s", self.hold_s, tick_hz, (1, 65535))

    @property
    def duration_s(self) -> float:
        """Length of the run, s."""
        return len(self.values_a) * self.hold_s
