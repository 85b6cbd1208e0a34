"""Can these records answer the question at all? Each refusal says what is wrong and what would help."""

from collections.abc import Sequence

import numpy as np

from discrepancy.data.overlap import check_independence
from discrepancy.data.plausible import check_sizes
from discrepancy.data.rest import check_moving, check_varying
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
        notes.extend(check_sizes(one, model))
    for probe in test:
        for one in train:
            check_independence(one, probe)
    return notes


def _check_excitation(one: Series, model: JointModel) -> None:
    check_varying(one.input, one.label, model.input)
    for channel in one.channels:
        if channel.row in (SPEED, POSITION):
            check_moving(channel.values, one.label, channel.name)
        elif float(np.std(channel.values)) <= 0.0:
            raise GapInputError(f"{one.label}: {channel.name} does not change; is its sensor connected?")
