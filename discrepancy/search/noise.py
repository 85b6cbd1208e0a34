"""The noise that a model is judged in: what repeats show beside it, else what the best candidate leaves."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from discrepancy.data.ranges import find_waves
from discrepancy.data.repeats import Pair
from discrepancy.fitting.noise import (
    fit_whitener,
    high_band_sigma,
    innovation_sigma,
    repeat_noise,
    sigma_or_floor,
)
from discrepancy.fitting.problem import Noise, SimulationProblem
from discrepancy.search.state import State

FloatArray = NDArray[np.float64]


def noise_from(problem: SimulationProblem, state: State) -> Noise:
    """Return the noise model that the residual of a good model shows."""
    sigma, whitener = {}, {}
    parts = residual_parts(problem, state)
    for c, channel in enumerate(problem.series[0].channels):
        realisations = [record[c] for record in parts]
        whitener[channel.name] = fit_whitener(realisations)
        sigma[channel.name] = max(innovation_sigma(realisations, whitener[channel.name]), 1e-12)
    return Noise(sigma=sigma, whitener=whitener)


def noise_beside(
    problem: SimulationProblem, state: State, known: Noise | None, pairs: Sequence[Pair] = ()
) -> Noise:
    """Return the noise to judge in: what repeats show, widened by output to what the best model leaves.

    An output that no model follows to its noise (a current between the samples of its loop) must not drown the others.
    """
    if known is None:
        return noise_from(problem, state)
    if pairs:
        # Repeats that began elsewhere differ by more than noise wherever the model lacks something.
        known = measure_noise(problem, residual_parts(problem, state), pairs)[1] or known
    sharp = replace(problem, noise=known)
    residual = sharp.measured() - sharp.flatten(sharp.simulate(state.fit.vector, state.fit.starts))
    sums: dict[str, FloatArray] = {}
    at = 0
    for one in sharp.series:
        for channel in one.channels:
            part = residual[at : at + one.n]
            more = np.array([part @ part, np.count_nonzero(channel.weight)])
            sums[channel.name] = sums.get(channel.name, np.zeros(2)) + more
            at += one.n
    sigma = {name: known.sigma[name] * max(1.0, float(np.sqrt(a / b))) for name, (a, b) in sums.items()}
    return replace(known, sigma=sigma)


def residual_parts(problem: SimulationProblem, state: State) -> list[list[FloatArray]]:
    """Return measured minus simulated, in SI units, by record and channel."""
    outputs = problem.simulate(state.fit.vector, state.fit.starts)
    return [
        [(channel.values - output[channel.row]) * (channel.weight > 0) for channel in one.channels]
        for one, output in zip(problem.series, outputs, strict=True)
    ]


def waves_left(problem: SimulationProblem, state: State) -> dict[str, tuple[float, ...]]:
    """Return the wave numbers over the angle at which what a model leaves repeats, 1/rad."""
    parts = residual_parts(problem, state)
    return find_waves(problem.series, [record[0] for record in parts], state.fit.vector)


def measure_noise(
    problem: SimulationProblem, parts: list[list[NDArray[np.float64]]], pairs: Sequence[Pair]
) -> tuple[Noise, Noise | None]:
    """Return white noise weights, and the full noise model where repeats show it."""
    names = [channel.name for channel in problem.series[0].channels]
    values = [channel.values for channel in problem.series[0].channels]
    if not pairs:
        sigma = {
            name: sigma_or_floor(high_band_sigma([record[c] for record in parts]), values[c])
            for c, name in enumerate(names)
        }
        return Noise(sigma=sigma), None
    realisations = repeat_noise(parts, pairs)
    white, sharp, whitener = {}, {}, {}
    for c, name in enumerate(names):
        white[name] = sigma_or_floor(float(np.std(np.concatenate(realisations[c]))), values[c])
        whitener[name] = fit_whitener(realisations[c])
        sharp[name] = sigma_or_floor(innovation_sigma(realisations[c], whitener[name]), values[c])
    return Noise(sigma=white), Noise(sigma=sharp, whitener=whitener)
