"""Which excitation would settle what is left open, predicted from the rival models themselves.

For rivals A and B the data that A predicts under a candidate excitation are fitted with B's parameters; what B
cannot follow
is the predicted distance (T-optimality: A. C. Atkinson, V. V. Fedorov, Biometrika 62(1), 1975). For a named effect
with a
poor parameter the candidates are ranked by the standard error that they would leave.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from discrepancy.data.series import SPEED, Channel, Series
from discrepancy.fitting.levenberg import fit
from discrepancy.fitting.problem import Noise, SimulationProblem
from discrepancy.search.state import State

FloatArray = NDArray[np.float64]

DURATION_S = 20.0
_STEP_S = 4e-3


@dataclass(frozen=True, slots=True, kw_only=True)
class RigLimits:
    """What the rig allows: amplitude of the current, A, and travel of the angle, rad."""

    amplitude: float
    travel: float = math.inf


@dataclass(frozen=True, slots=True, kw_only=True)
class Proposal:
    """One candidate excitation, its waveform and the campaign's words for it."""

    excitation: Mapping[str, Any]
    waveform: FloatArray


def candidate_excitations(limits: RigLimits) -> list[Proposal]:
    """Return excitations that the campaign runner knows, at full and at small amplitude."""
    time = np.arange(0.0, DURATION_S, _STEP_S)
    found = []
    for amplitude in (limits.amplitude, 0.3 * limits.amplitude):
        a = round(amplitude, 6)
        for period in (2.0, 10.0):
            wave = amplitude * np.sin(2 * np.pi * time / period)
            found.append(
                Proposal(excitation={"kind": "sine", "amplitude_A": a, "period_s": period}, waveform=wave)
            )
            wave = amplitude * np.clip(
                2.5 * (2 / np.pi) * np.arcsin(np.sin(2 * np.pi * time / period)), -1.0, 1.0
            )
            entry = {"kind": "trapezoid", "amplitude_A": a, "period_s": period, "rise_fraction": 0.2}
            found.append(Proposal(excitation=entry, waveform=wave))
        for end in (2.0, 10.0, 25.0):
            sweep = DURATION_S
            phase = 2 * np.pi * (0.1 * time + 0.5 * (end - 0.1) / sweep * time**2)
            entry = {"kind": "chirp", "amplitude_A": a, "sweep_s": sweep, "start_Hz": 0.1, "end_Hz": end}
            found.append(Proposal(excitation=entry, waveform=amplitude * np.sin(phase)))
    return found


def predicted_series(template: Series, proposal: Proposal) -> Series:
    """Return an empty record with this input, at rest at the start."""
    time = np.arange(proposal.waveform.size, dtype=np.float64) * _STEP_S
    zeros = np.zeros(time.size)
    channel = Channel(name=_speed_name(template), row=SPEED, values=zeros, weight=np.ones(time.size))
    return Series(
        label="predicted", step=_STEP_S, original_step=template.original_step, time_s=time, input=proposal.waveform,
        angle=np.empty(0), channels=(channel,), windows=np.array([-1], dtype=np.int64), starts=np.zeros((1, 2)),
    )  # fmt: skip


def _speed_name(template: Series) -> str:
    return next((c.name for c in template.channels if c.row == SPEED), template.channels[0].name)


def predicted_distance(series: Series, truth: State, rival: State, sigma: float) -> float:
    """Return how far the refitted rival stays from what `truth` predicts, in squared noise units."""
    name = series.channels[0].name
    problem = SimulationProblem(series=(series,), noise=Noise(sigma={name: sigma}))
    vector = problem.prepare(truth.fit.vector)
    output = problem.simulate(vector, problem.initial_starts())[0]
    if not np.all(np.isfinite(output)):
        return 0.0
    channel = Channel(name=name, row=SPEED, values=output[SPEED], weight=np.ones(series.n))
    full = SimulationProblem(series=(_with_channel(series, channel),), noise=problem.noise)
    return fit(full, rival.fit.parameters, rival.fit.vector, full.initial_starts(), 4).loss


def _with_channel(series: Series, channel: Channel) -> Series:
    return Series(
        label=series.label, step=series.step, original_step=series.original_step, time_s=series.time_s,
        input=series.input,
        angle=series.angle, channels=(channel,), windows=series.windows, starts=series.starts,
    )  # fmt: skip


def predicted_error(series: Series, state: State, owner: str, sigma: float) -> float:
    """Return the largest relative standard error of an effect's parameters after this experiment."""
    name = series.channels[0].name
    problem = SimulationProblem(series=(series,), noise=Noise(sigma={name: sigma}))
    done = fit(problem, state.fit.parameters, state.fit.vector, problem.initial_starts(), 0)
    covariance = np.linalg.pinv(done.normal() + 1e-9 * np.eye(len(done.parameters)), rcond=1e-14)
    worst = 0.0
    for i, parameter in enumerate(done.parameters):
        if parameter.owner != owner:
            continue
        value = float(done.vector[parameter.slot])
        error = math.sqrt(max(0.0, float(covariance[i, i]))) * parameter.slope(value)
        worst = max(worst, error / max(abs(value), 1e-12))
    return worst


def propose_between(
    template: Series, rivals: Sequence[State], names: Sequence[str], sigma: float, limits: RigLimits
) -> dict[str, Any] | None:
    """Return the excitation that separates the rivals best, None if none does."""
    if len(rivals) < 2:
        return None
    scored = []
    for proposal in candidate_excitations(limits):
        series = predicted_series(template, proposal)
        if _leaves_travel(series, rivals[0], limits):
            continue
        distance = min(
            predicted_distance(series, a, b, sigma) for a in rivals[:3] for b in rivals[:3] if a is not b
        )
        scored.append((distance, proposal))
    if not scored:
        return None
    distance, best = max(scored, key=lambda pair: pair[0])
    if distance < 1.0:
        return None
    return _entry(
        f"separates {' from '.join(names)}: predicted distance {math.sqrt(distance):.1f} noise deviations",
        names,
        best,
    )


def propose_for_parameter(
    template: Series, state: State, owner: str, sigma: float, limits: RigLimits
) -> dict[str, Any] | None:
    """Return the excitation that measures an effect's parameters best."""
    scored = []
    for proposal in candidate_excitations(limits):
        series = predicted_series(template, proposal)
        if not _leaves_travel(series, state, limits):
            scored.append((predicted_error(series, state, owner, sigma), proposal))
    scored = [pair for pair in scored if pair[0] > 0.0]
    if not scored:
        return None
    error, best = min(scored, key=lambda pair: pair[0])
    return _entry(f"measures {owner} to a relative standard error of {error:.1%}", [owner], best)


def _leaves_travel(series: Series, state: State, limits: RigLimits) -> bool:
    problem = SimulationProblem(series=(series,), noise=Noise(sigma={series.channels[0].name: 1.0}))
    output = problem.simulate(problem.prepare(state.fit.vector), problem.initial_starts())[0]
    return float(np.ptp(output[1])) > limits.travel


def _entry(why: str, separates: Sequence[str], proposal: Proposal) -> dict[str, Any]:
    return {
        "why": why,
        "separates": list(separates),
        "duration_s": DURATION_S,
        "excitation": dict(proposal.excitation),
    }


def campaign(entry: Mapping[str, Any], rig: str) -> dict[str, Any]:
    """Return the campaign file, as a mapping, that plays a proposed experiment twice for training and once for test."""
    excitation = {**entry["excitation"], "ramp_s": 0.5}
    records = [
        {"record": {"name": name, "duration_s": entry["duration_s"], "excitation": excitation}}
        for name in ("train", "repeat", "test")
    ]
    return {"name": "next-experiment", "description": entry["why"], "rig": rig, "steps": records}
