"""Regressors phi(k) = [-y(k-1).. -y(k-na), u(k-delay).. u(k-delay-nb+1)] of a data set (paper, eq. 5).

The residual terms of extended RLS are not here: they exist only while the estimator runs.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.dataset import Dataset, Vector
from estimators.structure import ModelStructure


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Regression:
    """A data set as rows of a linear regression y = phi' theta.

    Attributes:
        structure: orders and delay.
        phi: regressors, shape (M, na + nb).
        y: outputs, shape (M,).
        rows: index of each row's output in the data set, shape (M,).
        bounds: rows of each segment, as slices of phi.
    """

    structure: ModelStructure
    phi: NDArray[np.float64]
    y: Vector
    rows: NDArray[np.int64]
    bounds: tuple[slice, ...]


def build_regression(dataset: Dataset, structure: ModelStructure) -> Regression:
    """Build the rows of all segments; a segment too short for one row is left out.

    Raises:
        ValueError: If the data hold fewer rows than the model has parameters.
    """
    regression = build_rows(dataset, structure)
    n_rows = regression.y.size
    if n_rows <= structure.n_parameters:
        raise ValueError(
            f"{dataset.n} samples in {len(dataset.starts)} segments give {n_rows} regressors for "
            f"{structure.n_parameters} parameters; record more, or lower the order or the delay"
        )
    return regression


def build_rows(dataset: Dataset, structure: ModelStructure, first: int = 0) -> Regression:
    """Build the rows whose output is sample `first` or a later one, however few they are."""
    reach = structure.reach
    pieces = [np.arange(max(s.start + reach, first), s.stop, dtype=np.int64) for s in dataset.segments]
    pieces = [piece for piece in pieces if piece.size]
    rows = np.concatenate([np.empty(0, dtype=np.int64), *pieces])
    phi = np.empty((rows.size, structure.n_phi))
    for i in range(structure.na):
        np.negative(dataset.y[rows - (i + 1)], out=phi[:, i])
    for j in range(structure.nb):
        phi[:, structure.na + j] = dataset.u[rows - (structure.delay + j)]
    stops = np.cumsum([piece.size for piece in pieces])
    bounds = tuple(
        slice(int(stop - piece.size), int(stop)) for stop, piece in zip(stops, pieces, strict=True)
    )
    return Regression(structure=structure, phi=phi, y=dataset.y[rows], rows=rows, bounds=bounds)
