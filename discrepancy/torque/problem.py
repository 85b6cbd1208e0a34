"""Judge by torque: the motion is measured, the torque that it needs is computed and compared with the motor's.

In closed loop the controller hides a friction error from the position and shows it in the torque, and an open-loop
simulation
would drift. Angle, speed and acceleration come from zero-phase filtering; measured and computed torque pass the same
filter
and are decimated (the parallel decimation of M. Gautier, IDIM; A. Janot et al., IEEE TCST 22(1), 2014).
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, sosfiltfilt

from daq.recording.recording import Recording
from discrepancy.data.clean import check_share, check_time, find_outliers, repair
from discrepancy.data.rest import check_moving
from discrepancy.data.series import TORQUE, Channel, Series, angle_column
from discrepancy.errors import GapInputError
from discrepancy.fitting.problem import SimulationProblem, Starts
from discrepancy.model.schema import JointModel
from discrepancy.simulation import slots as s
from discrepancy.simulation.kernels.inverse import torque_record
from discrepancy.torque.limits import TorqueLimits

FloatArray = NDArray[np.float64]

LEAST_BLOCKS = 12
FILTER_MEMORIES = 4.0
"""A held-out block is at least so many times longer than the shared filter's memory (one over its edge)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Motion:
    """Measured motion of one record at full rate, zero-phase filtered, and the filter of its torque.

    Attributes:
        edge_hz: edge of the low-pass filter that measured and computed torque share.
        keep: rows that are judged.
    """

    time_s: FloatArray
    input: FloatArray
    angle: FloatArray
    speed: FloatArray
    acceleration: FloatArray
    sections: FloatArray
    edge_hz: float
    keep: slice

    def smooth(self, values: FloatArray) -> FloatArray:
        """Low-pass and decimate."""
        return np.asarray(sosfiltfilt(self.sections, values)[self.keep])


def read_motion(
    recording: Recording, model: JointModel, label: str, limits: TorqueLimits | None = None
) -> tuple[Motion, Series]:
    """Return the motion and the judged torque of a record.

    Raises:
        GapInputError: neither a position nor a speed column, or a broken time axis.
    """
    limits = limits or TorqueLimits()
    names = set(recording.columns)
    if model.input not in names:
        raise GapInputError(
            f"{label}: column {model.input!r} is missing; the recording has {', '.join(sorted(names))}"
        )
    raw_time = np.array(recording.columns["time_s"], dtype=np.float64)
    step = check_time(raw_time, label)
    raw_time = raw_time - raw_time[0]
    time = np.arange(0.0, raw_time[-1] + 0.5 * step, step)

    def column(name: str) -> FloatArray:
        values = np.asarray(recording.columns[name], dtype=np.float64)
        bad = find_outliers(values)
        check_share(bad, label, name)
        return np.interp(time, raw_time, repair(raw_time, values, bad))

    position = angle_column(recording, model)
    speed_name = "speed_m_s" if model.is_linear_axis else "speed_rad_s"
    if position is None and speed_name not in names:
        raise GapInputError(
            f"{label}: judged by torque, a position or speed column is needed; the recording has "
            f"{', '.join(sorted(names))}"
        )
    angle = column(position) if position else np.cumsum(column(speed_name)) * step
    rough = column(speed_name) if speed_name in names else np.gradient(angle, step)
    check_moving(rough, label, speed_name if speed_name in names else str(position))
    edge = _edge(rough, step, limits.band_factor)
    sections = butter(4, edge * 2.0 * step, output="sos")
    # The motion's own filter is wider: the edge itself is left to the filter that measured and computed torque share.
    wide = butter(4, min(0.8, limits.differentiation_factor * edge * 2.0 * step), output="sos")
    smooth = sosfiltfilt(wide, angle)
    speed = sosfiltfilt(wide, rough) if speed_name in names else np.gradient(smooth, step)
    factor = max(1, int(0.25 / (edge * step)))
    margin = round(1.0 / (edge * step))
    keep = slice(margin, time.size - margin, factor)
    motion = Motion(
        time_s=time, input=column(model.input), angle=smooth, speed=speed, acceleration=np.gradient(speed, step),
        sections=sections, edge_hz=edge, keep=keep,
    )  # fmt: skip
    return motion, _judged(motion, model, (label, step * factor, step), limits.rest_share)


def _judged(motion: Motion, model: JointModel, about: tuple[str, float, float], rest_share: float) -> Series:
    """Return the judged torque of a motion; `about` holds label, judged step and original step."""
    label, step, original = about
    constants = [q.value for n, q in model.parameters.items() if n in ("torque_constant", "force_constant")]
    measured = motion.smooth((constants[0] if constants else 1.0) * motion.input)
    moving = np.abs(motion.speed[motion.keep]) > rest_share * np.quantile(np.abs(motion.speed), 0.995)
    channel = Channel(
        name="force" if model.is_linear_axis else "torque", row=TORQUE, values=measured,
        weight=moving.astype(np.float64),
    )  # fmt: skip
    return Series(
        label=label, step=step, original_step=original, time_s=motion.time_s[motion.keep],
        input=motion.smooth(motion.input), angle=motion.angle[motion.keep], channels=(channel,),
        windows=np.array([-1], dtype=np.int64), starts=np.zeros((1, 2)),
    )  # fmt: skip


def _edge(speed: FloatArray, step: float, band_factor: float) -> float:
    """Return the filter's edge in Hz, from where the speed's power lies."""
    power = np.abs(np.fft.rfft(speed - speed.mean())) ** 2
    frequency = np.fft.rfftfreq(speed.size, step)
    total = np.cumsum(power)
    band = float(frequency[np.searchsorted(total, 0.95 * total[-1])])
    return min(0.2 / step, max(band_factor * band, 20.0 / (speed.size * step)))


@dataclass(frozen=True, slots=True, kw_only=True)
class TorqueProblem(SimulationProblem):
    """Inverse dynamics against the measured torque; has no starting states to project out."""

    motions: tuple[Motion, ...]
    nominal: float

    def simulate(self, vector: FloatArray, starts: Starts) -> list[FloatArray]:
        """Return the needed torque of each record in row TORQUE, shape (4, n)."""
        found = []
        constant = float(vector[s.TORQUE_CONSTANT])
        for motion, one in zip(self.motions, self.series, strict=True):
            needed = torque_record(
                vector,
                motion.time_s,
                motion.input,
                (motion.angle, motion.speed, motion.acceleration),
                constant,
            )
            # As the nameplate's torque constant would read the input. The measured side must not move with a fitted
            # constant: a joint of no inertia and a motor of no torque would balance perfectly.
            torque = needed * (self.nominal / constant)
            # The joint feels the input of `shift` ago (a held one acts half a sample late): what it needs was asked for
            # so much earlier.
            shift = float(vector[s.INPUT_SHIFT])
            if shift != 0.0:
                torque = np.interp(motion.time_s + shift, motion.time_s, torque)
            output = np.zeros((4, one.n))
            output[TORQUE] = motion.smooth(torque)
            found.append(output)
        return found

    def blocks(self, seconds: float) -> list[list[slice]]:
        """Return at least a dozen blocks where the filter's memory allows it: a torque balance has no other memory.

        Three blocks of a short record each hold a part of the motion that the others lack; the law that predicts such
        a block best is chosen by chance.
        """
        found: list[list[slice]] = []
        offset = 0
        for motion, one in zip(self.motions, self.series, strict=True):
            duration = one.n * one.step
            finest = int(duration * motion.edge_hz / FILTER_MEMORIES)
            count = max(2, round(duration / seconds), min(LEAST_BLOCKS, finest))
            edges = np.linspace(offset, offset + one.n, count + 1).astype(int)
            found.extend([slice(int(a), int(b))] for a, b in pairwise(edges))
            offset += one.n
        return found

    def start_columns(self, vector: FloatArray, starts: Starts, at: list[FloatArray]) -> list[FloatArray]:
        """Return nothing: the motion is measured, no state has to be guessed."""
        return []

    def start_rows(self, starts: Starts) -> tuple[int, ...]:
        """Return nothing, likewise."""
        return ()
