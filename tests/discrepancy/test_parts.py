"""The parts of the workflow: noise, repeats, cleaning, location, fanning out."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from daq.recording.recording import Recording, recording_from_columns
from discrepancy.assemble import column_names
from discrepancy.data.clean import find_outliers
from discrepancy.data.repeats import find_repeats
from discrepancy.data.series import bin_series, read_series
from discrepancy.effects.spec import Port
from discrepancy.fitting.noise import fit_whitener, high_band_sigma
from discrepancy.locate import locate
from discrepancy.model.schema import JointModel
from discrepancy.prepare import Prepared, prepare_simulation
from discrepancy.search.choice import Contender
from discrepancy.search.greedy import fit_all, screen
from discrepancy.search.noise import residual_parts
from discrepancy.search.options import SearchOptions
from discrepancy.simulation import slots as s
from tests.discrepancy.recorder import make_recording


def test_high_band_finds_the_noise_under_a_smooth_signal() -> None:
    rng = np.random.default_rng(0)
    values = np.sin(np.arange(20_000) * 0.01) + rng.normal(0.0, 0.05, 20_000)
    # Sampling error of a robust estimate from 20,000 correlated differences: about 1.5 %.
    assert high_band_sigma([values]) == pytest.approx(0.05, rel=0.05)


def test_whitener_recovers_an_autoregressive_noise() -> None:
    rng = np.random.default_rng(1)
    noise = np.zeros(50_000)
    for k, shock in enumerate(rng.normal(size=50_000)[1:], start=1):
        noise[k] = 0.8 * noise[k - 1] + shock
    # Standard error of a coefficient: sqrt((1 - 0.64) / 50,000) = 0.003.
    assert fit_whitener([noise])[1] == pytest.approx(-0.8, abs=0.015)


def test_single_spikes_are_outliers_and_steps_are_not() -> None:
    values = np.repeat([0.0, 1.0, -1.0, 0.5], 200) + np.random.default_rng(2).normal(0.0, 0.01, 800)
    values[333] += 5.0
    values[500] = np.nan
    assert set(np.flatnonzero(find_outliers(values))) == {333, 500}


def test_the_first_sample_after_a_step_is_no_outlier_though_the_signal_decays_from_it() -> None:
    after = np.r_[0.0, np.cumsum([3.9, 12.7, 20.8, 23.4, 22.7, 18.0])]
    values = np.r_[np.full(300, 35.0), after - 143.0, np.full(300, -41.0)]
    values += np.random.default_rng(3).normal(0.0, 0.1, values.size)
    assert not find_outliers(values).any()


def test_records_with_the_same_input_are_repeats(nameplate: JointModel) -> None:
    series = [read_series(make_recording({}, k, input_seed=k // 2), nameplate, str(k)) for k in (0, 1, 2)]
    assert [(pair.first, pair.second) for pair in find_repeats(series)] == [(0, 1)]


def test_a_hole_restarts_the_simulation(nameplate: JointModel) -> None:
    whole = make_recording({}, 1)
    keep = np.r_[0:3000, 3500:8000]
    columns = {name: np.array(whole.column(name))[keep] for name in ("time_s", "current_A", "speed_rad_s")}
    series = read_series(_recording(columns), nameplate, "holed")
    assert list(series.windows) == [-1, -3001]
    assert list(bin_series(series, 4).windows) == [-1, -751]


def test_dry_friction_is_located_at_the_torque_over_the_speed(nameplate: JointModel) -> None:
    prepared = _prepared(nameplate)
    parts = residual_parts(prepared.problem, prepared.state)
    places = locate(prepared.problem.series, parts, prepared.state.fit.vector, column_names(nameplate))
    assert (places[0].port, places[0].driver) == (Port.TORQUE, "speed_rad_s")
    assert places[0].share > 0.5


@pytest.mark.slow
def test_fanning_out_gives_the_same_fits(nameplate: JointModel) -> None:
    prepared = _prepared(nameplate)
    with ThreadPoolExecutor(2) as executor:
        spread = replace(prepared.context, executor=executor)
        found = [_fit_all(replace(prepared, context=context)) for context in (spread, prepared.context)]
    assert [(c.name, c.white_loss) for c in found[0]] == [(c.name, c.white_loss) for c in found[1]]


def _fit_all(prepared: Prepared) -> list[Contender]:
    problem, state, context = prepared.problem, prepared.state, prepared.context
    screened = screen(problem, state, prepared.ranges, context)
    return fit_all(problem, state, screened, (prepared.ranges, SearchOptions(), context))


def _recording(columns: dict[str, NDArray[np.float64]]) -> Recording:
    return recording_from_columns(columns, sample_time_s=2e-3)


def _prepared(nameplate: JointModel) -> Prepared:
    record = make_recording({s.COULOMB: 0.15}, 1)
    return prepare_simulation(nameplate, [read_series(record, nameplate, "train")], None)
