"""Excitations drawn at random from all that a campaign can play: what designed experiments are compared with."""

from typing import Any

import numpy as np

from discrepancy.design.excitations import SHARES

KINDS = ("sine", "trapezoid", "chirp", "multisine", "prbs", "staircase")
PERIODS_S = (0.5, 20.0)
BITS_S = (0.01, 0.5)
LEVELS_S = (0.2, 2.0)
END_HZ = (1.0, 50.0)


def random_excitation(generator: np.random.Generator, limit: float) -> dict[str, Any]:
    """Return an excitation of any kind, size, offset and pace, in the campaign's words; not all are admissible."""

    def pace(low: float, high: float) -> float:
        return float(np.exp(generator.uniform(np.log(low), np.log(high))))

    kind = str(generator.choice(KINDS))
    largest = SHARES[0] * limit
    amplitude = generator.uniform(0.05, 1.0) * largest
    offset = generator.uniform(-1.0, 1.0) * (largest - amplitude) if generator.random() < 0.5 else 0.0
    words: dict[str, Any] = {"kind": kind, "amplitude_A": float(amplitude), "offset_A": float(offset)}
    seed = int(generator.integers(1, 2**31))
    more: dict[str, dict[str, Any]] = {
        "sine": {"period_s": pace(*PERIODS_S)},
        "trapezoid": {
            "period_s": pace(*PERIODS_S),
            "rise_fraction": float(generator.uniform(0.05, 0.5)),
        },
        "chirp": {"sweep_s": pace(2.0, 20.0), "start_Hz": 0.1, "end_Hz": pace(*END_HZ)},
        "multisine": {
            "period_s": 10.0,
            "lines": int(generator.integers(3, 40)),
            "lowest": int(round(pace(1.0, 80.0))),
            "step": int(generator.integers(1, 10)),
            "seed": seed,
        },
        "prbs": {"register_bits": 9, "bit_s": pace(*BITS_S), "seed": seed},
        "staircase": {"levels": int(generator.integers(3, 16)), "level_s": pace(*LEVELS_S)},
    }
    return {**words, **more[kind]}
