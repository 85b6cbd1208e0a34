"""Judge an excitation before it is sent: current, heat, slew, and where the joint would go.

Theory of operation. The reference is computed tick by tick; its peak, its steepest step and its I2t heat
(first-order average of the squared phase current, half the squares of the torque- and flux-producing ones) are read
off directly. Speed and travel come from the nameplate model of the joint at the motor shaft, with the controller's
slow centring loop when it is on:

    theta' = omega
    omega' = (Kt * (r - G * x) - B * omega) / J
    x'     = 2 pi f * (theta - x)

a linear system, discretised exactly for an input held over a few ticks. Friction and cogging are left out, both of
which only slow the joint down; against a wrong nameplate the controller has its own limits. A caller that knows the
joint better hands over a `MotionPredictor` in the nameplate's place.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from daq.errors import ExcitationLimitError
from daq.excitation.kernels import average_heat, simulate_joint
from daq.excitation.spec import Excitation, Setpoints
from daq.excitation.waveform import run_length, sample_reference

Floats = NDArray[np.float64]
_STEP_TICKS = 10
_BLOCK_TICKS = 1_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class RigLimits:
    """What the rig bears; the controller enforces the same numbers by itself.

    Attributes:
        current_limit_a: Largest torque-producing current reference, A.
        rated_current_a: Phase current that the motor bears for ever, A rms.
        i2t_time_s: Time constant of the heat model, s.
        flux_current_a: Flux-producing current, which heats as well, A.
        slew_limit_a_s: Steepest change of the reference that belt and gear bear, A/s.
        speed_limit_rad_s: Largest speed of the motor shaft, rad/s.
        travel_min_rad: Lower end of the travel, motor shaft, rad.
        travel_max_rad: Upper end of the travel, motor shaft, rad.
    """

    current_limit_a: float
    rated_current_a: float
    i2t_time_s: float
    flux_current_a: float = 0.0
    slew_limit_a_s: float = 10_000.0
    speed_limit_rad_s: float
    travel_min_rad: float
    travel_max_rad: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Nameplate:
    """The joint as its data sheets describe it, everything counted at the motor shaft.

    Attributes:
        inertia_kg_m2: Motor, pulleys and joint, kg m^2.
        viscous_friction_nm_s_rad: The same for friction, N m s/rad.
        torque_constant_nm_a: Torque per torque-producing current, N m/A.
    """

    inertia_kg_m2: float
    viscous_friction_nm_s_rad: float
    torque_constant_nm_a: float


@dataclass(frozen=True, slots=True, kw_only=True)
class StartCondition:
    """How the run begins.

    Attributes:
        position_rad: Position of the motor shaft before the run, from the centre of travel, rad.
        centring_gain_a_rad: Gain of the centring loop, A/rad; 0 when it is off.
        centring_bandwidth_hz: Its low-pass, Hz.
        tick_hz: Controller ticks per second.
    """

    position_rad: float = 0.0
    centring_gain_a_rad: float = 0.0
    centring_bandwidth_hz: float = 0.005
    tick_hz: int = 2500


class MotionPredictor(Protocol):
    """Knows the joint better than its nameplate does."""

    def predict_motion(
        self, reference: Floats, start: StartCondition, step_s: float
    ) -> tuple[Floats, Floats, Floats]:
        """Return centring current (A), speed (rad/s) and position (rad), shape (n,) each.

        Args:
            reference: Current averaged over each step, A, shape (n,).
            start: How the run begins.
            step_s: Length of a step, s.
        """


@dataclass(frozen=True, slots=True, kw_only=True)
class ExcitationReport:
    """What an excitation is predicted to do.

    Attributes:
        duration_s: Length of the run, s.
        peak_current_a: Largest magnitude of reference and centring together, A.
        rms_current_a: Root mean square of the reference, A.
        heat_current_a: Square root of the largest I2t average: compares with the rated phase current, A rms.
        slew_a_s: Steepest change of the reference, A/s.
        peak_speed_rad_s: Largest magnitude of the motor shaft's speed, rad/s.
        position_min_rad: Lowest predicted position, rad.
        position_max_rad: Highest predicted position, rad.
    """

    duration_s: float
    peak_current_a: float
    rms_current_a: float
    heat_current_a: float
    slew_a_s: float
    peak_speed_rad_s: float
    position_min_rad: float
    position_max_rad: float


def check_excitation(
    excitation: Excitation | Setpoints,
    limits: RigLimits,
    nameplate: Nameplate | MotionPredictor,
    start: StartCondition,
) -> ExcitationReport:
    """Predict what `excitation` does to the rig and refuse it when a limit would be exceeded.

    Raises:
        ExcitationLimitError: With the first quantity that is too large, its value and its limit.
        ValueError: The excitation has no end, or a field lies outside what the generator can play.
    """
    report = predict_excitation(excitation, limits, nameplate, start)
    for quantity, value, limit, unit, remedy in _judgements(report, limits):
        # NaN must not pass either, hence the negation.
        if not abs(value) <= abs(limit):
            raise ExcitationLimitError(
                f"{quantity} of {value:.4g} {unit} exceeds the limit of {limit:.4g} {unit}; {remedy}",
                quantity=quantity,
                value=value,
                limit=limit,
            )
    return report


def predict_excitation(
    excitation: Excitation | Setpoints,
    limits: RigLimits,
    nameplate: Nameplate | MotionPredictor,
    start: StartCondition,
) -> ExcitationReport:
    """Return what `excitation` would do, without judging it."""
    length = run_length(excitation, start.tick_hz)
    if length is None:
        raise ValueError(
            "duration_s=0: this excitation never ends by itself; give the length of the run in s"
        )
    mean, slew_a = _reference(excitation, length, start.tick_hz)
    step_s = _STEP_TICKS / start.tick_hz
    if isinstance(nameplate, Nameplate):
        centring, speed, position = _simulate(mean, nameplate, start, step_s)
    else:
        centring, speed, position = nameplate.predict_motion(mean, start, step_s)
    squared = (mean + centring) ** 2 + limits.flux_current_a**2
    return ExcitationReport(
        duration_s=length / start.tick_hz,
        peak_current_a=float(np.abs(mean + centring).max()),
        rms_current_a=float(np.sqrt(np.mean(mean**2))),
        heat_current_a=float(
            np.sqrt(average_heat(squared / 2.0, -np.expm1(-step_s / limits.i2t_time_s)).max())
        ),
        slew_a_s=slew_a * start.tick_hz,
        peak_speed_rad_s=float(np.abs(speed).max()),
        position_min_rad=float(position.min()),
        position_max_rad=float(position.max()),
    )


def _judgements(report: ExcitationReport, limits: RigLimits) -> list[tuple[str, float, float, str, str]]:
    smaller = "use a smaller amplitude"
    travel = "use a smaller amplitude or offset, a shorter period, or the centring loop"
    low, high = report.position_min_rad, report.position_max_rad
    return [
        ("peak current", report.peak_current_a, limits.current_limit_a, "A", smaller),
        (
            "I2t current",
            report.heat_current_a,
            limits.rated_current_a,
            "A rms",
            f"{smaller} or a shorter run",
        ),
        (
            "slew",
            report.slew_a_s,
            limits.slew_limit_a_s,
            "A/s",
            "use a smaller amplitude, a slower rise or a ramp",
        ),
        (
            "predicted speed",
            report.peak_speed_rad_s,
            limits.speed_limit_rad_s,
            "rad/s",
            f"{smaller} or a shorter period",
        ),
        ("predicted travel", min(low, 0.0), limits.travel_min_rad, "rad", travel),
        ("predicted travel", max(high, 0.0), limits.travel_max_rad, "rad", travel),
    ]


def _reference(excitation: Excitation | Setpoints, length: int, tick_hz: int) -> tuple[Floats, float]:
    """Return the reference averaged over steps of `_STEP_TICKS`, A, and its largest change in one tick, A.

    Blocks keep the memory bounded however long the run is. The controller ramps the last value of a run down, but
    plays set-points as they are, so only these can end in a step.
    """
    last_tick = length if isinstance(excitation, Setpoints) else length - 1
    means, slew, last = [], 0.0, 0.0
    for first in range(0, length, _BLOCK_TICKS):
        stop = min(first + _BLOCK_TICKS, -(-(length + 1) // _STEP_TICKS) * _STEP_TICKS)
        ticks = np.minimum(np.arange(first, stop), last_tick)
        reference = sample_reference(excitation, ticks, tick_hz)
        slew = max(slew, float(np.abs(np.diff(reference, prepend=last)).max()))
        last = float(reference[-1])
        means.append(reference.reshape(-1, _STEP_TICKS).mean(axis=1))
    return np.concatenate(means), slew


def _simulate(
    reference: Floats, nameplate: Nameplate, start: StartCondition, step_s: float
) -> tuple[Floats, Floats, Floats]:
    """Return centring current (A), speed (rad/s) and position (rad) for a reference held over each step."""
    from scipy.linalg import expm  # slow to import: only when an excitation is checked

    inertia, gain = nameplate.inertia_kg_m2, start.centring_gain_a_rad
    torque, friction = nameplate.torque_constant_nm_a, nameplate.viscous_friction_nm_s_rad
    rate = 2 * np.pi * start.centring_bandwidth_hz
    system = np.zeros((4, 4))
    system[0, 1] = 1.0
    system[1, 1:] = -friction / inertia, -gain * torque / inertia, torque / inertia
    system[2, [0, 2]] = rate, -rate
    # The fourth state is the input itself, which does not change within a step: its column is the step's response.
    exact = expm(system * step_s)
    begin = np.array([start.position_rad, 0.0, start.position_rad])
    transition, drive = np.ascontiguousarray(exact[:3, :3]), np.ascontiguousarray(exact[:3, 3])
    return simulate_joint(reference, transition, drive, begin, gain)
