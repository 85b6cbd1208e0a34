"""The ends of a record, where a smoothed speed is wrong: what is left out, and when."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from daq.recording.recording import Recording, recording_from_columns
from discrepancy.data.ends import END_S, ENDS_LEFT_OUT, end_samples, without_ends
from discrepancy.data.series import SPEED, Series, read_series
from discrepancy.model.schema import JointModel
from discrepancy.search.at_ends import ends_decide
from discrepancy.search.course import Course
from discrepancy.search.outcome import Step
from discrepancy.simulation import slots as s
from discrepancy.workflow import run_gap
from tests.discrepancy.recorder import STEP_S, make_recording

FEW = round(END_S / STEP_S)
NOISE = 0.01


@pytest.fixture
def holed(nameplate: JointModel) -> Series:
    """Return a record with a hole of 0.2 s in its middle."""
    whole = make_recording({s.COULOMB: 0.15}, 1)
    kept = np.r_[0:4000, 4100:8000]
    columns = {name: values[kept] for name, values in whole.columns.items()}
    return read_series(recording_from_columns(columns, sample_time_s=STEP_S), nameplate, "r")


def test_both_ends_are_cut_off_and_windows_stay_at_their_samples(holed: Series) -> None:
    cut = without_ends(holed)
    assert cut.n == holed.n - 2 * FEW
    assert np.array_equal(cut.channels[0].values, holed.channels[0].values[FEW:-FEW])
    assert np.array_equal(cut.input, holed.input[FEW:-FEW])
    assert cut.time_s[0] == 0.0
    (_, old), (_, new) = holed.edges[0], cut.edges[0]
    assert cut.channels[0].values[new] == holed.channels[0].values[old]
    assert cut.starts[1] == pytest.approx(holed.starts[1])


def test_of_a_short_record_a_fiftieth_is_an_end(nameplate: JointModel) -> None:
    short = make_recording({}, 1, played=np.sin(np.arange(500) * 0.02))
    assert end_samples(read_series(short, nameplate, "r")) == 10


def test_a_record_without_a_speed_has_no_ends(holed: Series) -> None:
    measured = replace(holed, channels=(replace(holed.channels[0], row=SPEED + 1),))
    assert without_ends(measured) is measured


def with_error_at(course: Course, rows: slice) -> Course:
    """Return the course with 30 noise rms more on some samples of its only record."""
    one = course.problem.series[0]
    values = one.channels[0].values.copy()
    values[rows] += 30.0 * NOISE
    series = (replace(one, channels=(replace(one.channels[0], values=values),)),)
    return replace(course, problem=replace(course.problem, series=series))


@pytest.mark.parametrize(("rows", "decides"), [(slice(-5, None), True), (slice(400, 405), False)])
def test_what_is_left_at_the_ends_decides_only_there(begun: Course, rows: slice, decides: bool) -> None:
    wrong = with_error_at(begun, rows)
    assert ends_decide(wrong.problem, wrong.steps, doubted=True) is decides
    assert not ends_decide(wrong.problem, wrong.steps, doubted=False)


@pytest.mark.parametrize(("inside", "decides"), [(0.5, True), (1.0, False)])
def test_a_name_that_closes_the_ends_alone_rests_on_them(begun: Course, inside: float, decides: bool) -> None:
    base = begun.steps[-1]
    vector = base.state.fit.vector.copy()
    vector[s.VISCOUS] *= 1.1
    named = Step(
        state=replace(base.state, fit=replace(base.state.fit, vector=vector)), added="quadratic_drag"
    )
    problem = begun.problem
    one = problem.series[0]
    before, after = (
        problem.simulate(problem.prepare(step.state.fit.vector), step.state.fit.starts)[0][SPEED]
        for step in (base, named)
    )
    # Half way between both models a sample is as far from one as from the other: nothing is closed there.
    values = before + inside * (after - before)
    few = end_samples(one)
    values[:few], values[-few:] = after[:few], after[-few:]
    series = (replace(one, channels=(replace(one.channels[0], values=values),)),)
    assert ends_decide(replace(problem, series=series), (base, named), doubted=False) is decides


def quiet_session(hidden: dict[int, float], seed: int) -> Recording:
    """Return a short sine, the speed wrong by up to 25 noise rms in its last 60 ms."""
    played = 0.6 * np.sin(2.0 * np.pi * 0.5 * np.arange(5000) * STEP_S)
    whole = make_recording(hidden, seed, played=played)
    speed: NDArray[np.float64] = whole.columns["speed_rad_s"].copy()
    speed[-30:] -= 25.0 * NOISE * np.linspace(0.0, 1.0, 30) ** 2
    return recording_from_columns({**whole.columns, "speed_rad_s": speed}, sample_time_s=STEP_S)


@pytest.mark.parametrize(
    ("hidden", "names"),
    [({s.QUADRATIC: 0.3}, ("quadratic_drag",)), ({s.COULOMB: 0.1}, ("coulomb_friction",)), ({}, ())],
)
def test_a_wrong_end_of_a_record_hides_nothing_and_is_nothing(
    nameplate: JointModel, hidden: dict[int, float], names: tuple[str, ...]
) -> None:
    train = [quiet_session(hidden, seed) for seed in (1, 2)]
    result = run_gap(nameplate, train, [make_recording(hidden, 11)])
    assert result.effects == names
    assert result.verdict == ("named" if names else "none")
    assert ENDS_LEFT_OUT in result.notes
