"""What the figures are made of: thinning, averages with intervals, spectra, laws."""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from daq.recording.recording import Recording
from discrepancy.data.ranges import signal_ranges
from discrepancy.data.series import bin_series, read_series
from discrepancy.design.detectable import detectable_effects
from discrepancy.effects.table import EFFECTS
from discrepancy.fitting.levenberg import fit
from discrepancy.fitting.parameters import (
    FitParameter,
    base_parameters,
    effect_parameters,
    model_vector,
)
from discrepancy.fitting.problem import Noise, SimulationProblem
from discrepancy.model.schema import JointModel
from discrepancy.report.binning import Samples, bin_samples
from discrepancy.report.law import LawMaker
from discrepancy.report.spectra import spectrum, white_density
from discrepancy.report.thin import thin, worst_stretch
from discrepancy.search.context import Context
from discrepancy.search.options import SearchOptions
from discrepancy.search.standard_errors import robust_covariance
from discrepancy.search.state import State
from discrepancy.simulation import slots as s
from tests.discrepancy.report.conftest import make_curve

Recorder = Callable[[Mapping[int, float], int], Recording]
FloatArray = NDArray[np.float64]
NOISE = 0.01
BIN = 5


def fitted(
    model: JointModel, records: list[Recording], added: tuple[str, ...]
) -> tuple[SimulationProblem, State]:
    """Fit a model with known effects to records whose noise is known."""
    series = tuple(bin_series(read_series(r, model, f"train[{i}]"), BIN) for i, r in enumerate(records))
    problem = SimulationProblem(series=series, noise=Noise(sigma={"speed_rad_s": NOISE / np.sqrt(BIN)}))
    vector = model_vector(model)
    ranges = signal_ranges(series, vector)
    base = base_parameters(model, ranges, None)
    parameters: list[FitParameter] = list(base)
    for name in added:
        parameters.extend(effect_parameters(EFFECTS[name], (), ranges))
        vector[EFFECTS[name].parameters[0].slot] = 0.05
    done = fit(problem, parameters, vector, problem.initial_starts(), 20)
    return problem, State(base=tuple(base), given=(), added=added, fit=done)


@pytest.mark.parametrize("n", [2001, 3999, 7900, 100_000])
def test_thinning_leaves_no_stretch_out(n: int) -> None:
    time, _ = thin(np.arange(float(n)), np.random.default_rng(1).normal(size=n), 2000)
    width = n // 1000 + 1
    assert time.size <= 2000
    assert time[0] < width
    assert time[-1] >= n - width
    assert np.diff(time).max() < 2 * width


def test_thinning_keeps_the_peaks() -> None:
    values = np.zeros(100_000)
    values[54_321], values[7] = 3.0, -2.0
    time, kept = thin(np.arange(100_000.0), values)
    assert time.size <= 2001
    assert (kept.max(), kept.min()) == (3.0, -2.0)
    assert np.all(np.diff(time) > 0)


def test_the_worst_stretch_lies_where_the_error_is() -> None:
    begin, end = worst_stretch(make_curve(0.5))
    assert 7.9 < begin < end <= 12.0


def test_intervals_of_correlated_noise_cover_the_truth() -> None:
    rng = np.random.default_rng(3)
    n, block = 40_000, 200
    covered = []
    for _ in range(20):
        slow = np.repeat(rng.normal(0.0, 0.1, n // block), block)
        x = rng.uniform(-1.0, 1.0, n)
        y = 0.3 * np.sign(x) + slow + rng.normal(0.0, 0.1, n)
        samples = Samples(x=x, y=y, per=np.ones(n), block=np.arange(n) // block)
        cells = bin_samples(samples).cells
        covered.append(np.abs(cells.mean - 0.3 * np.sign(cells.x)) < cells.error)
    # The cells of one draw share their slow noise, so the coverage of 20 draws scatters by some percent.
    assert 0.88 < float(np.mean(covered)) <= 1.0


def test_cells_give_a_coefficient_where_a_ratio_is_asked_for() -> None:
    rng = np.random.default_rng(4)
    x, per = rng.uniform(0.0, 1.0, 5000), rng.normal(0.0, 1.0, 5000)
    samples = Samples(x=x, y=(2.0 + x) * per, per=per, block=np.arange(5000) // 50)
    cells = bin_samples(samples).cells
    np.testing.assert_allclose(cells.mean, 2.0 + cells.x, atol=0.01)


def test_white_noise_lies_on_the_density_of_its_standard_deviation() -> None:
    time = np.arange(60_000, dtype=np.float64) * 1e-3
    found = spectrum(time, np.random.default_rng(5).normal(0.0, 0.02, time.size))
    level = white_density(0.02, time)
    # The lowest cells average few lines, all others many.
    assert abs(float(np.mean(found.density[40:])) / level - 1.0) < 0.03


def test_the_named_law_lies_in_its_band_and_on_the_measured_cells(
    nameplate: JointModel, record: Recorder
) -> None:
    hidden = {s.COULOMB: 0.12}
    problem, state = fitted(nameplate, [record(hidden, 1), record(hidden, 2)], ("coulomb_friction",))
    covariance = robust_covariance(problem, state.fit)
    picture = LawMaker(problem=problem, state=state, covariance=covariance, linear=False).named(
        "coulomb_friction"
    )
    assert picture is not None
    truth = 0.12 * np.sign(picture.law_x)
    assert np.mean((picture.low <= truth) & (truth <= picture.high)) > 0.95
    measured = picture.points
    off = np.abs(measured.mean - 0.12 * np.sign(measured.x))
    # 95 % intervals; a step of the input that the smoothing smears may put a thin cell outside.
    assert np.mean(off < measured.error) > 0.8
    assert np.median(off) < 0.01


def test_the_band_of_a_hardly_known_parameter_is_taken_inside_its_bounds(
    nameplate: JointModel, record: Recorder
) -> None:
    problem, state = fitted(nameplate, [record({s.COULOMB: 0.12}, 1)], ("belt_compliance",))
    covariance = np.diag([(1e4 * max(1.0, abs(p.upper))) ** 2 for p in state.fit.parameters])
    with np.errstate(over="raise"):
        picture = LawMaker(problem=problem, state=state, covariance=covariance, linear=False).named(
            "belt_compliance"
        )
    assert picture is not None
    assert picture.law.size > 0


def test_an_effect_that_is_not_in_the_model_has_no_picture(nameplate: JointModel, record: Recorder) -> None:
    problem, state = fitted(nameplate, [record({}, 1)], ())
    maker = LawMaker(problem=problem, state=state, covariance=np.zeros((2, 2)), linear=False)
    assert maker.named("backlash") is None


def test_what_is_called_detectable_is_seen_in_the_data(nameplate: JointModel, record: Recorder) -> None:
    problem, state = fitted(nameplate, [record({}, 1), record({}, 2)], ())
    options = SearchOptions()
    context = Context(executor=None, repeat_noise=problem.noise, bin_size=np.full(1, float(BIN)))
    found = {one.id: one.size for one in detectable_effects(problem, state, options, context)}
    size = found["coulomb_friction"]
    assert 0.0 < size < 0.02
    # Put twice that strength into the joint: the fit with the effect must win by more than the search asks for.
    strong = [record({s.COULOMB: 2.0 * size}, 1), record({s.COULOMB: 2.0 * size}, 2)]
    without, with_it = fitted(nameplate, strong, ())[1], fitted(nameplate, strong, ("coulomb_friction",))[1]
    assert without.fit.loss - with_it.fit.loss > options.alarm + options.per_parameter
    # And a fifth of it: it must not.
    weak = [record({s.COULOMB: 0.2 * size}, 1), record({s.COULOMB: 0.2 * size}, 2)]
    without, with_it = fitted(nameplate, weak, ())[1], fitted(nameplate, weak, ("coulomb_friction",))[1]
    assert without.fit.loss - with_it.fit.loss < options.alarm + options.per_parameter


def test_an_effect_that_one_of_two_outputs_shows_is_detectable(
    nameplate: JointModel, record: Recorder
) -> None:
    both = replace(nameplate, outputs=(*nameplate.outputs, "position_rad"))
    one = bin_series(read_series(record({}, 1), both, "train"), BIN)
    sizes = np.array([np.std(channel.values) / NOISE for channel in one.channels])
    quiet = Noise(sigma={channel.name: NOISE / np.sqrt(BIN) for channel in one.channels})
    problem = SimulationProblem(series=(one,), noise=quiet)
    base = base_parameters(both, signal_ranges((one,), model_vector(both)), None)
    state = State(
        base=tuple(base), given=(), added=(),
        fit=fit(problem, base, model_vector(both), problem.initial_starts(), 20),
    )  # fmt: skip

    def smallest(signal: FloatArray) -> float:
        context = Context(executor=None, repeat_noise=quiet, bin_size=np.full(2, float(BIN)), signal=signal)
        found = detectable_effects(problem, state, SearchOptions(), context)
        return next((o.size for o in found if o.id == "coulomb_friction"), np.inf)

    # A thousandth of the speed's size is visible, whatever part of a position of a thousand times the size would be.
    alone, beside = smallest(sizes * [1.0, 1e9]), smallest(sizes * [1.0, 1.0])
    assert np.isfinite(alone)
    assert beside <= alone
    assert smallest(sizes * 1e9) == np.inf


def test_a_simulation_that_runs_away_leaves_empty_cells() -> None:
    none = np.empty(0)
    nothing = Samples(x=none, y=none, per=none, block=np.empty(0, dtype=np.int64))
    cells = bin_samples(nothing, np.array([-1.0, 0.0, 1.0])).cells
    assert np.all(np.isnan(cells.mean))
    assert np.all(cells.count == 0)
