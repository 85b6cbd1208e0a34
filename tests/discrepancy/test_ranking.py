"""Which law leads a round: by held-out blocks, unless another leaves less than half of what that one leaves."""

from dataclasses import replace

import pytest

from discrepancy.data.series import read_series
from discrepancy.model.schema import JointModel
from discrepancy.prepare import prepare_simulation
from discrepancy.search import greedy
from discrepancy.search.choice import Contender
from discrepancy.search.options import SearchOptions
from tests.discrepancy.recorder import make_recording


@pytest.mark.parametrize(
    ("leaves", "leading"),
    [
        pytest.param(10.0, "coulomb_friction", id="much less, beside a third that leaves about as much"),
        pytest.param(14.0, "load_dependent_friction", id="not less than half"),
    ],
)
def test_a_law_that_leaves_less_than_half_goes_before_one_that_seemed_to_predict(
    nameplate: JointModel, leaves: float, leading: str
) -> None:
    series = [read_series(make_recording({}, seed), nameplate, str(seed)) for seed in (1, 2)]
    start = prepare_simulation(nameplate, series, None).state

    def contender(name: str, white_loss: float, fall: float) -> Contender:
        state = replace(start, added=(name,))
        return Contender(name=name, state=state, white_loss=white_loss, fall=fall)

    judged = [
        contender("load_dependent_friction", 1.0 + 24.0, 6100.0),
        contender("stribeck_friction", 1.0 + leaves + 1.0, 5800.0),
        contender("coulomb_friction", 1.0 + leaves, 5900.0),
    ]
    ranked = greedy._ranked(judged, 1.0, SearchOptions())
    assert ranked[0].name == leading
