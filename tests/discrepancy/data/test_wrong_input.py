"""Records that cannot answer, or look wrong: each gets a sentence with the row, the value and what would help."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from daq.recording.recording import Recording, recording_from_columns
from discrepancy.data.checks import check_inputs
from discrepancy.data.clean import find_outliers
from discrepancy.data.identifiable import hold_unidentified
from discrepancy.data.series import read_series
from discrepancy.errors import GapInputError
from discrepancy.model.reader import parse_model
from discrepancy.model.schema import JointModel
from discrepancy.model.structure import hold_scale
from discrepancy.simulate import simulate_recording
from discrepancy.simulation import slots as s
from discrepancy.torque.problem import read_motion
from discrepancy.workflow import run_gap
from tests.discrepancy.recorder import make_recording

Columns = dict[str, NDArray[np.float64]]
Change = Callable[[Columns], object]
NAMES = ("time_s", "current_A", "speed_rad_s")
STEP_S = 2e-3


def columns_of(seed: int = 1, **changes: float) -> Columns:
    """Return the columns of a joint's record; seeds from 10 on have an input of their own."""
    slots = {getattr(s, name.upper()): value for name, value in changes.items()}
    record = make_recording(slots, seed, input_seed=0 if seed < 10 else seed)
    return {name: np.array(record.column(name)) for name in NAMES}


def as_record(columns: Columns) -> Recording:
    return recording_from_columns(columns, sample_time_s=STEP_S)


def notes_on(model: JointModel, columns: Columns, test: Columns | None = None) -> list[str]:
    """Check a training record beside a sound test record."""
    train = read_series(as_record(columns), model, "train")
    return check_inputs(model, [train], [read_series(as_record(test or columns_of(11)), model, "test")])


def put(column: str, rows: slice | int | NDArray[np.int64], value: float) -> Change:
    """Return a change that writes a value into rows of a column."""
    return lambda columns: columns[column].__setitem__(rows, value)


def test_a_sound_record_needs_no_note(nameplate: JointModel) -> None:
    assert notes_on(nameplate, columns_of()) == []


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (put("current_A", slice(None), 0.3), "current_A is constant .0.3.; nothing excites"),
        (
            lambda c: c.update(current_A=0.5 + np.random.default_rng(0).normal(0.0, 0.01, c["time_s"].size)),
            "current_A is constant .0.5 with noise of 0.01.",
        ),
        (put("speed_rad_s", slice(None), 0.0), "speed_rad_s does not change: the motor is at rest"),
        (
            lambda c: c.update(speed_rad_s=np.random.default_rng(0).normal(0.0, 1e-3, c["time_s"].size)),
            "the motor is at rest",
        ),
        (lambda c: c.update({k: v[:200] for k, v in c.items()}), "200 samples are too few to name an effect"),
        (lambda c: c.pop("speed_rad_s"), "column 'speed_rad_s' of model 'joint' is missing; the recording has"),
        (lambda c: c.pop("current_A"), "column 'current_A' of model 'joint' is missing"),
        (lambda c: c["time_s"].__isub__(np.where(c["time_s"] > 2.0, 1.0, 0.0)), "row 1001 .* runs backwards 1 times"),
        (put("time_s", slice(500, 503), 1.0), "does not rise at row 501 .*: 2 rows repeat the time"),
        (put("time_s", 7, np.nan), "time_s is no number at row 7 .nan., 1 rows"),
        (put("time_s", -1, np.inf), "time_s is no number at row 7999 .inf."),
        (put("speed_rad_s", slice(None), np.nan), "100% of speed_rad_s is no measurement"),
        (put("current_A", slice(0, 4000), np.inf), "50% of current_A is no measurement"),
    ],
)  # fmt: skip
def test_a_record_that_cannot_answer_is_refused_with_the_reason(
    change: Change, message: str, nameplate: JointModel
) -> None:
    columns = columns_of()
    change(columns)
    with pytest.raises(GapInputError, match=message) as caught:
        notes_on(nameplate, columns)
    assert str(caught.value).startswith("train: ")


@pytest.mark.parametrize(
    ("column", "factor", "suspect"),
    [
        ("current_A", 1000.0, "times less, .* mA, mm or g"),
        ("speed_rad_s", 1000.0, "times more, .* mA, mm or g"),
        ("speed_rad_s", 180.0 / np.pi, "times more, .* degrees"),
    ],
)
def test_a_unit_that_is_wrong_by_a_lot_is_refused_and_guessed(
    column: str, factor: float, suspect: str, nameplate: JointModel
) -> None:
    columns = columns_of(coulomb=0.12)
    columns[column] *= factor
    with pytest.raises(GapInputError, match=f"nameplate predicts .*{suspect}.* A unit must be wrong"):
        notes_on(nameplate, columns)


def test_a_nameplate_in_grams_is_refused_by_the_size_of_the_motion() -> None:
    parameters = {
        "inertia": {"value": 500.0, "fixed": True},
        "viscous_friction": 800.0,
        "torque_constant": 1.05,
    }
    with pytest.raises(GapInputError, match="times more, .* of the model's parameters"):
        notes_on(parse_model({"name": "joint", "parameters": parameters}), columns_of())


def test_a_speed_in_rpm_is_noted(nameplate: JointModel) -> None:
    columns = columns_of()
    columns["speed_rad_s"] *= 30.0 / np.pi
    [note] = notes_on(nameplate, columns)
    assert "rpm where rad/s is meant? Check the units" in note


def test_a_turned_sign_is_refused(nameplate: JointModel) -> None:
    columns = columns_of(coulomb=0.12)
    columns["speed_rad_s"] *= -1.0
    with pytest.raises(GapInputError, match="moves against current_A .* turn the sign"):
        notes_on(nameplate, columns)


@pytest.mark.parametrize(
    "taken",
    [slice(None), slice(1500, 5500), slice(0, 3000)],
    ids=["the whole", "a piece", "its beginning"],
)
def test_a_test_record_out_of_the_training_record_is_refused(taken: slice, nameplate: JointModel) -> None:
    train = columns_of()
    test = {name: np.round(values[taken], 8) for name, values in train.items()}
    with pytest.raises(GapInputError, match="test is the same recording as train, or a part of it"):
        notes_on(nameplate, train, test)


def test_a_repeat_is_another_recording(nameplate: JointModel) -> None:
    assert notes_on(nameplate, columns_of(1), columns_of(2)) == []


def test_spikes_beside_each_other_are_all_found() -> None:
    rng = np.random.default_rng(4)
    values = np.sin(np.arange(8000) * 0.01) + rng.normal(0.0, 0.01, 8000)
    rows = rng.choice(8000, 80, replace=False)
    values[rows] += rng.choice([-1.0, 1.0], 80) * rng.uniform(3.0, 6.0, 80)
    found = set(np.flatnonzero(find_outliers(values)))
    assert found == set(rows)


def test_spikes_missing_values_and_holes_are_told(nameplate: JointModel) -> None:
    columns = columns_of()
    columns["speed_rad_s"][[100, 2000, 2001]] = [9.0, np.nan, np.inf]
    keep = np.ones(8000, dtype=bool)
    keep[3000:3100] = False
    notes = notes_on(nameplate, {name: values[keep] for name, values in columns.items()})
    assert any("3 samples are no measurements" in note for note in notes)
    assert any("1 holes in the time axis" in note for note in notes)


@pytest.mark.slow
def test_dry_friction_is_named_through_spikes_and_holes(nameplate: JointModel) -> None:
    rng, n = np.random.default_rng(5), 3000
    columns = {name: values[:n] for name, values in columns_of(1, coulomb=0.12).items()}
    for name, size in (("current_A", 3.0), ("speed_rad_s", 2.0)):
        rows = rng.choice(n, n // 100, replace=False)
        columns[name][rows] += size * rng.choice([-1.0, 1.0], rows.size)
    keep = np.ones(n, dtype=bool)
    for first in rng.integers(300, n - 300, 5):
        keep[first : first + 40] = False
    damaged = as_record({name: values[keep] for name, values in columns.items()})
    result = run_gap(nameplate, [damaged], [as_record(columns_of(11, coulomb=0.12))])
    assert result.effects == ("coulomb_friction",)
    # 5 %: the truth is the package's own kernel; what is left are the holes' unknown currents.
    assert result.terms[0].parameters["level"].value == pytest.approx(0.12, rel=0.05)


def joint_with(free: tuple[str, ...]) -> JointModel:
    """Return the true joint with some parameters free."""
    values = {"inertia": 0.5, "viscous_friction": 0.9, "torque_constant": 1.0}
    return parse_model(
        {"parameters": {name: {"value": value, "fixed": name not in free} for name, value in values.items()}}
    )


def slow_record(period_s: float) -> Columns:
    """Return 4,000 samples of two periods in which the speed is in balance with the current."""
    time = np.arange(4000) * (2.0 * period_s / 4000)
    current = 0.5 * np.sin(2 * np.pi * time / period_s)
    speed = current / 0.9 + np.random.default_rng(6).normal(0.0, 1e-3, time.size)
    return {"time_s": time, "current_A": current, "speed_rad_s": speed}


def test_inertia_is_held_where_the_speed_never_changes_quickly() -> None:
    model = joint_with(("inertia", "viscous_friction"))
    train = read_series(as_record(slow_record(2000.0)), model, "train")
    held, notes = hold_unidentified(model, [train])
    assert held.parameters["inertia"].fixed
    assert not held.parameters["viscous_friction"].fixed
    assert "inertia cannot be identified from these records" in notes[0]
    assert "record with faster changes of the current (shorter than about 0.56 s)" in notes[0]


def test_viscous_friction_is_held_where_the_record_is_too_fast_for_it() -> None:
    model = joint_with(("viscous_friction", "inertia"))
    time = np.linspace(0.0, 0.04, 4000)
    current = np.cos(2 * np.pi * time / 0.002)
    speed: NDArray[np.float64] = np.cumsum(current) * (1e-5 / 0.5)
    train = read_series(
        as_record({"time_s": time, "current_A": current, "speed_rad_s": speed}), model, "train"
    )
    held, notes = hold_unidentified(model, [train])
    assert [name for name, q in held.parameters.items() if q.fixed] == ["viscous_friction", "torque_constant"]
    assert "record longer stretches at steady speeds" in notes[0]


def test_a_rich_record_holds_nothing() -> None:
    model = joint_with(("inertia", "viscous_friction"))
    train = read_series(as_record(columns_of()), model, "train")
    assert hold_unidentified(model, [train]) == (model, [])


def test_a_friction_of_zero_on_the_nameplate_can_be_identified() -> None:
    model = parse_model({"parameters": {"inertia": {"value": 0.5, "fixed": True}, "viscous_friction": 0.0}})
    train = read_series(as_record(columns_of()), model, "train")
    assert hold_unidentified(model, [train])[1] == []


def test_of_three_free_parameters_the_scale_is_held_and_said() -> None:
    held, [note] = hold_scale(joint_with(("inertia", "viscous_friction", "torque_constant")))
    assert held.parameters["torque_constant"].fixed
    assert "cannot all be identified" in note
    assert "torque measurement at standstill" in note


def test_without_that_rule_all_three_show_as_unidentified() -> None:
    model = joint_with(("inertia", "viscous_friction", "torque_constant"))
    train = read_series(as_record(columns_of()), model, "train")
    held, notes = hold_unidentified(model, [train])
    assert len(notes) == 1
    assert sum(not q.fixed for q in held.parameters.values()) == 2


def test_a_joint_at_rest_is_refused_when_judged_by_torque() -> None:
    model = parse_model({"judge_by": "torque", "parameters": {"inertia": 0.5, "torque_constant": 1.0}})
    columns = columns_of()
    columns["speed_rad_s"] = np.random.default_rng(0).normal(0.0, 1e-3, 8000)
    with pytest.raises(GapInputError, match="speed_rad_s does not change: the motor is at rest"):
        read_motion(as_record(columns), model, "train")


def test_few_samples_are_enough_to_simulate(nameplate: JointModel) -> None:
    columns = {name: values[:50] for name, values in columns_of().items()}
    simulated = simulate_recording(nameplate, as_record(columns), "short").simulated["speed_rad_s"]
    assert simulated.size == 50
    assert np.all(np.isfinite(simulated))


def test_what_is_too_short_to_simulate_is_refused_for_that_reason(nameplate: JointModel) -> None:
    columns = {name: values[:3] for name, values in columns_of().items()}
    with pytest.raises(GapInputError, match="3 samples are too few to simulate; at least 4"):
        simulate_recording(nameplate, as_record(columns), "short")
