"""The whole chain: recalibrate, locate, name, add, show. Arrays in, `GapResult` out; files are written by `report`."""

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace

from daq.recording.recording import Recording
from discrepancy.assemble import assemble, column_names
from discrepancy.data.checks import check_inputs
from discrepancy.data.ends import ENDS_LEFT_OUT, without_ends
from discrepancy.data.identifiable import hold_unidentified
from discrepancy.data.series import SPEED, Series, bin_series, read_series
from discrepancy.design.limits import RigLimits
from discrepancy.errors import GapInputError
from discrepancy.evaluate import simulation_scorer
from discrepancy.model.schema import JointModel, Judge
from discrepancy.model.structure import hold_scale
from discrepancy.prepare import Prepared, noise_floor, prepare_simulation, prepare_torque
from discrepancy.result import GapResult
from discrepancy.search.balance_fit import choose_parameters
from discrepancy.search.by_balance import choose_names
from discrepancy.search.explained import explained_away
from discrepancy.search.finish import search
from discrepancy.search.free_run import refine_free_run
from discrepancy.search.full_rate import refine_full_rate
from discrepancy.search.options import SearchOptions
from discrepancy.search.outcome import SearchOutcome
from discrepancy.torque.limits import TorqueLimits
from discrepancy.torque.prepare import torque_scorer
from discrepancy.torque.problem import read_motion

BEFORE_THE_SENSOR = frozenset({"current_saturation", "inverter_dead_time"})
"""Effects between the reference and the measured current: a record that holds both drives the joint by what is left."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GapOptions:
    """How the workflow runs.

    Attributes:
        search: decision limits.
        torque: limits of judging by torque.
        executor: where candidate fits run; None means in this process, one after the other.
        limits: what a proposed experiment may do to the rig; None takes what the records have shown safe.
    """

    search: SearchOptions = field(default_factory=SearchOptions)
    torque: TorqueLimits = field(default_factory=TorqueLimits)
    executor: Executor | None = None
    limits: RigLimits | None = None


def run_gap(
    model: JointModel,
    train_records: Sequence[Recording],
    test_records: Sequence[Recording],
    options: GapOptions | None = None,
) -> GapResult:
    """Find what the model lacks.

    Raises:
        GapInputError: the recordings or the model do not allow an answer; the message says what would.
    """
    chosen = options or GapOptions()
    model, scale_notes = hold_scale(model)
    if model.judge_by is Judge.TORQUE:
        return _run_torque(model, (train_records, test_records), chosen, scale_notes)
    train = [read_series(record, model, f"train[{i}]") for i, record in enumerate(train_records)]
    test = [read_series(record, model, f"test[{i}]") for i, record in enumerate(test_records)]
    notes = scale_notes + check_inputs(model, train, test)
    model, held = hold_unidentified(model, train)
    notes += held
    outcome = _search_simulation(model, (train, train_records), chosen)
    if outcome.at_ends:
        train, test = [without_ends(one) for one in train], [without_ends(one) for one in test]
        outcome = _search_simulation(model, (train, train_records), chosen)
        notes.append(ENDS_LEFT_OUT)
    floor = noise_floor(train, outcome.problem)
    return assemble(model, outcome, simulation_scorer(train, test), (floor, notes, chosen.limits))


def _search_simulation(
    model: JointModel, records: tuple[Sequence[Series], Sequence[Recording]], chosen: GapOptions
) -> SearchOutcome:
    train, train_records = records
    prepared = prepare_simulation(model, train, chosen.executor)
    names = column_names(model)
    context = prepared.context
    if model.input == "current_A" and all("current_ref_A" in record.columns for record in train_records):
        context = replace(context, excluded=context.excluded | BEFORE_THE_SENSOR)
    has_speed = any(channel.row == SPEED for channel in train[0].channels)
    # A position drifts, and names taken for following the drift would be exchanged one for another at length: there the
    # torque balance is the second opinion.
    limits = replace(chosen.search, exchanges=chosen.search.exchanges and has_speed)
    outcome = search(prepared.problem, prepared.state, prepared.ranges, limits, context, names)
    if not has_speed:
        whole = [bin_series(one, prepared.factor) for one in train]
        balance = _balance_of_position(model, train_records, chosen)
        outcome = outcome if balance is None else choose_names(outcome, balance, whole)
        outcome = refine_free_run(outcome, whole)
        outcome = outcome if balance is None else choose_parameters(outcome, balance, whole)
    return refine_full_rate(outcome, train)


def _run_torque(
    model: JointModel,
    records: tuple[Sequence[Recording], Sequence[Recording]],
    chosen: GapOptions,
    scale_notes: list[str],
) -> GapResult:
    train_records, test_records = records
    train = [
        read_motion(record, model, f"train[{i}]", chosen.torque) for i, record in enumerate(train_records)
    ]
    test = [read_motion(record, model, f"test[{i}]", chosen.torque) for i, record in enumerate(test_records)]
    notes = scale_notes + check_inputs(model, [one for _, one in train], [one for _, one in test])
    prepared = prepare_torque(model, train, chosen.executor)
    outcome = _search_torque(model, prepared, chosen)
    scorer = torque_scorer(model, train, test)
    return assemble(model, outcome, scorer, (prepared.noise_floor, notes, chosen.limits))


def _search_torque(model: JointModel, prepared: Prepared, chosen: GapOptions) -> SearchOutcome:
    limits = replace(
        chosen.search,
        material_rms=max(chosen.search.material_rms, chosen.torque.material_rms),
        simpler=max(chosen.search.simpler, chosen.torque.form_error),
    )
    names = column_names(model)
    outcome = search(prepared.problem, prepared.state, prepared.ranges, limits, prepared.context, names)
    away = explained_away(outcome.rounds, outcome.steps[-1].state.added, limits)
    return replace(outcome, notes=(*outcome.notes, *away))


def _balance_of_position(
    model: JointModel, records: Sequence[Recording], chosen: GapOptions
) -> SearchOutcome | None:
    """Search the torque balance of records of a position; None where they do not allow one."""
    try:
        train = [read_motion(one, model, f"train[{i}]", chosen.torque) for i, one in enumerate(records)]
    except GapInputError:
        return None
    return _search_torque(model, prepare_torque(model, train, chosen.executor), chosen)
