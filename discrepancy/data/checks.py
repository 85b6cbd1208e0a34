"""Can these records answer the question at all? Each refusal says what is wrong and what would help."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from discrepancy.data.series import POSITION, SPEED, Series
from discrepancy.errors import GapInputError
from discrepancy.model.schema import JointModel


def check_inputs(model: JointModel, train: Sequence[Series], test: Sequence[Series]) -> list[str]:
    """Return notes for the report.

    Raises:
        GapInputError: no records, no excitation, a joint at rest, or test data that were used for training.
    """
    if not train or not test:
        raise GapInputError("at least one training and one test record are needed; give --train and --test")
    notes = []
    for one in (*train, *test):
        _check_excitation(one, model)
        if one.outliers:
            notes.append(
                f"{one.label}: {one.outliers} samples are no measurements (spikes or missing values) and do not count"
            )
        if len(one.windows) > 1:
            notes.append(
                f"{one.label}: {len(one.windows) - 1} holes in the time axis; the simulation starts anew behind each"
            )
    for probe in test:
        for one in train:
            _check_independence(one, probe)
    return notes


def _check_excitation(one: Series, model: JointModel) -> None:
    size = float(np.std(one.input))
    if size <= 1e-6 * max(1e-12, float(np.max(np.abs(one.input)))):
        raise GapInputError(
            f"{one.label}: {model.input} is constant ({one.input[0]:.4g}); nothing excites the joint. Record "
            f"with a varying current"
        )
    for channel in one.channels:
        spread = float(np.std(channel.values))
        if spread <= 0.0 or (channel.row in (SPEED, POSITION) and _is_at_rest(channel.values)):
            raise GapInputError(
                f"{one.label}: {channel.name} does not change: the motor is at rest. Record with a current that "
                f"moves the joint"
            )


def _is_at_rest(values: NDArray[np.float64]) -> bool:
    """Whether a signal holds nothing but white noise: no part of it persists from one sample to the next few."""
    centred = values - values.mean()
    power = float(centred @ centred)
    if power <= 0.0:
        return True
    lags = [float(centred[k:] @ centred[:-k]) / power for k in (1, 2, 3, 5)]
    return bool(max(lags) < 5.0 / np.sqrt(values.size) + 0.02)


def _check_independence(one: Series, probe: Series) -> None:
    n = min(one.n, probe.n)
    if n != max(one.n, probe.n):
        return
    for a, b in zip(one.channels, probe.channels, strict=True):
        if not np.array_equal(a.values[:n], b.values[:n]):
            return
    raise GapInputError(
        f"{probe.label} is the same recording as {one.label}: a test must not have been used for training; "
        f"record another"
    )
