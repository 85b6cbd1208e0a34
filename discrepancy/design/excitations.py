"""Excitations that may be proposed: the campaign's words for each, and the waveform that they stand for.

One family for every way in which effects part: slow ramps through zero speed (dry friction and what precedes it),
trapezoids and levels of different height (drag, saturation), bands of frequencies (delay, lags, springs), random steps,
offsets (asymmetry, load), and long records (drifts). The waveforms are those of docs/protocol.md up to random phases
and bits, which a prediction does not need to know.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from discrepancy.design.limits import RigLimits

FloatArray = NDArray[np.float64]

SHARES = (0.95, 0.65, 0.4, 0.2)
"""Amplitudes that are tried, as parts of what the rig allows; the rest of it is left to the centring loop."""
NEIGHBOURS = (0.75, 1.3)
"""A good candidate's amplitude and period are varied by these factors."""
_PACE = ("period_s", "sweep_s", "level_s", "bit_s")
RAMP_S = 0.5
TABLE_HOLD_S = 0.02
_HEIGHTS = (0.25, -0.25, 0.5, -0.5, 0.75, -0.75, 1.0, -1.0)
_RAMP_VALUES = 12
_HELD_VALUES = 36


@dataclass(frozen=True, slots=True, kw_only=True)
class Candidate:
    """One excitation in the campaign's words.

    Attributes:
        jump: largest sudden change of the input.
    """

    excitation: Mapping[str, Any]  # Any: values of a campaign's keys
    jump: float = 0.0


def candidate_excitations(limits: RigLimits) -> list[Candidate]:
    """Return excitations that the campaign runner knows, from full to small amplitude."""
    found = []
    for share in SHARES:
        a = round(share * limits.amplitude, 4)
        if a > 0.0:
            found += [*_swings(a), *_bands(a), *_steps(a)]
    return [one for one in found if one.jump <= limits.jump]


def _swings(a: float) -> list[Candidate]:
    """Return sines, ramps through zero, trapezoids and swings about an offset."""
    sines = [{"kind": "sine", "amplitude_A": a, "period_s": period} for period in (0.5, 1.0, 2.0, 4.0, 10.0)]
    slow = [
        {"kind": "trapezoid", "amplitude_A": a, "period_s": period, "rise_fraction": 0.5}
        for period in (2.5, 5.0, 10.0, 20.0)
    ]
    held = [
        {"kind": "trapezoid", "amplitude_A": a, "period_s": period, "rise_fraction": 0.2}
        for period in (1.0, 2.0, 5.0, 10.0)
    ]
    half = round(0.5 * a, 4)
    leaning = [
        {"kind": "sine", "amplitude_A": half, "offset_A": sign * half, "period_s": 2.0} for sign in (1, -1)
    ]
    return [Candidate(excitation=one) for one in (*sines, *slow, *held, *leaning)]


def _bands(a: float) -> list[Candidate]:
    """Return multisines of three bands and sweeps."""
    bands = [(1, 2, 20), (8, 4, 30), (80, 10, 40)]  # of 10 s: 0.1 to 3.9 Hz, 0.8 to 12.4 Hz, 8 to 47 Hz
    found = [
        {"kind": "multisine", "amplitude_A": a, "period_s": 10.0, "lines": n, "lowest": low, "step": step, "seed": 7}
        for low, step, n in bands
    ]  # fmt: skip
    sweeps = [
        {"kind": "chirp", "amplitude_A": a, "sweep_s": sweep, "start_Hz": 0.1, "end_Hz": end}
        for sweep, end in ((10.0, 25.0), (5.0, 5.0))
    ]
    return [Candidate(excitation=one) for one in (*found, *sweeps)]


def _steps(a: float) -> list[Candidate]:
    """Return random steps, levels, and trapezoids of growing height."""
    prbs = [
        Candidate(
            excitation={"kind": "prbs", "amplitude_A": a, "register_bits": 9, "bit_s": bit, "seed": 7},
            jump=2.0 * a,
        )
        for bit in (0.02, 0.2)
    ]
    levels = {"kind": "staircase", "amplitude_A": a, "levels": 9, "level_s": 1.0}
    values = growing_trapezoids(a)
    table = {"kind": "table", "values_A": values, "hold_s": TABLE_HOLD_S}
    rise = float(np.max(np.abs(np.diff(values, prepend=0.0))))
    return [*prbs, Candidate(excitation=levels, jump=a / 4.0), Candidate(excitation=table, jump=rise)]


def variations(candidate: Candidate, limits: RigLimits) -> list[Candidate]:
    """Return the neighbours of a candidate: smaller and larger, faster and slower, all within amplitude and jump."""
    words = candidate.excitation
    if "amplitude_A" not in words:
        return []
    found = []
    size = words["amplitude_A"] + abs(words.get("offset_A", 0.0))
    for factor in NEIGHBOURS:
        grown = min(factor, SHARES[0] * limits.amplitude / size)
        if grown != 1.0:
            scaled = {
                key: round(words[key] * grown, 4) for key in ("amplitude_A", "offset_A") if key in words
            }
            found.append(replace(candidate, excitation={**words, **scaled}, jump=candidate.jump * grown))
        paced = [{**words, key: round(words[key] * factor, 4)} for key in _PACE if key in words]
        found += [replace(candidate, excitation=one) for one in paced]
    return [one for one in found if one.jump <= limits.jump]


def growing_trapezoids(amplitude: float) -> list[float]:
    """Return trapezoids of growing height and either sign, which end at zero; a value for each `TABLE_HOLD_S`."""
    rise = np.arange(1, _RAMP_VALUES + 1) / _RAMP_VALUES
    shape = np.concatenate([rise, np.ones(_HELD_VALUES), rise[::-1] - 1.0 / _RAMP_VALUES])
    return [round(float(value), 4) for value in amplitude * np.concatenate([h * shape for h in _HEIGHTS])]


def waveform(excitation: Mapping[str, Any], duration_s: float, step_s: float) -> FloatArray:
    """Return the input at the middle of each step, faded in and out as the campaign plays it, shape (n,)."""
    time: FloatArray = (np.arange(round(duration_s / step_s), dtype=np.float64) + 0.5) * step_s
    fade = np.clip(np.minimum(time, duration_s - time) / RAMP_S, 0.0, 1.0)
    if excitation["kind"] == "table":
        values = np.asarray(excitation["values_A"], dtype=np.float64)
        return np.asarray(fade * values[(time / excitation["hold_s"]).astype(int) % values.size])
    shape = _SHAPES[excitation["kind"]](excitation, time)
    level = excitation.get("offset_A", 0.0) + excitation["amplitude_A"] * shape
    return np.asarray(fade * level, dtype=np.float64)


def _sine(e: Mapping[str, Any], time: FloatArray) -> FloatArray:
    return np.asarray(np.sin(2 * np.pi * time / e["period_s"]))


def _trapezoid(e: Mapping[str, Any], time: FloatArray) -> FloatArray:
    triangle = (2 / np.pi) * np.arcsin(_sine(e, time))
    return np.asarray(np.clip(0.5 / e["rise_fraction"] * triangle, -1.0, 1.0))


def _chirp(e: Mapping[str, Any], time: FloatArray) -> FloatArray:
    t = time % e["sweep_s"]
    rate = (e["end_Hz"] - e["start_Hz"]) / e["sweep_s"]
    return np.asarray(np.sin(2 * np.pi * (e["start_Hz"] * t + 0.5 * rate * t**2)))


def _multisine(e: Mapping[str, Any], time: FloatArray) -> FloatArray:
    harmonics = e["lowest"] + e["step"] * np.arange(e["lines"])
    phases = np.random.default_rng(e["seed"]).uniform(0, 2 * np.pi, e["lines"])

    def wave(t: FloatArray) -> FloatArray:
        return np.asarray(
            np.sin(2 * np.pi * np.outer(harmonics, t) / e["period_s"] + phases[:, None]).sum(axis=0)
        )

    peak = np.max(np.abs(wave(np.arange(8192) * e["period_s"] / 8192)))
    return np.asarray(wave(time) / peak)


def _prbs(e: Mapping[str, Any], time: FloatArray) -> FloatArray:
    bits = np.random.default_rng(e["seed"]).choice([-1.0, 1.0], size=2 ** e["register_bits"] - 1)
    return np.asarray(bits[(time / e["bit_s"]).astype(int) % bits.size])


def _staircase(e: Mapping[str, Any], time: FloatArray) -> FloatArray:
    """Return levels that rise from zero to the top, fall to the bottom and come back."""
    half = (e["levels"] - 1) // 2
    up = np.arange(half + 1)
    levels = np.concatenate([up, up[-2::-1], -up[1:], -up[-2:0:-1]]) / half
    return np.asarray(levels[(time / e["level_s"]).astype(int) % levels.size])


_SHAPES = {
    "sine": _sine,
    "trapezoid": _trapezoid,
    "chirp": _chirp,
    "multisine": _multisine,
    "prbs": _prbs,
    "staircase": _staircase,
}
