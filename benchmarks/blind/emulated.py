"""Make a case with the emulated controller's physics: induction motor in dq equations under its current control."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.blind import excitation
from benchmarks.blind.added_noise import AddedNoise, draw_noise
from benchmarks.blind.conditions import CONDITIONS, CURRENT_PORT, Case, Condition, Noise, Training
from benchmarks.blind.draw import Drawn, draw_case
from benchmarks.blind.excitation import TICK_S
from benchmarks.blind.gap import Linear, gap_of, rms
from benchmarks.blind.mapping import Truth, joint_figures, true_values
from benchmarks.blind.question import SPEED, Answer, Json, Question
from benchmarks.blind.rig import OBSERVER_HZ, Played, UnusableRunError, play
from daq.recording.derived_speed import describe_speed
from daq.speed.filters import DEFAULT_OPTIONS
from mock_dsp.scenario.rig_constants import MechanicsConstants, RigConstants, SensorConstants
from mock_dsp.scenario.schema import Effect, Scenario

FloatArray = NDArray[np.float64]

TACHO = "rectified_speed_sensor"
NAMEPLATE_VISCOUS = 0.9
NAMEPLATE_CONSTANT = 1.0
TRIES = 20
LEAST_AT_STOP = 0.01
"""Share of a record that must be spent beyond an end stop for it to be part of the question."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Made:
    """One case: what is asked, what was hidden, and the noise-free speed of the test record, shape (n,)."""

    question: Question
    answer: Answer
    clean_test: FloatArray


def make_emulated(case: Case) -> Made:
    """Make a case from its seed; a draw that trips a limit is drawn again, whatever is hidden.

    Raises:
        UnusableRunError: no draw of TRIES can be played.
    """
    for attempt in range(TRIES):
        generator = np.random.default_rng([case.seed, attempt])
        try:
            return _make(case, CONDITIONS[case.condition], generator)
        except UnusableRunError as error:
            last = error
    raise UnusableRunError(f"case {case.condition}/{case.seed}: {last}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Session:
    """What was played: the hidden effects, the rig, and for each record its scenario and columns."""

    drawn: Drawn
    rig: RigConstants
    scenarios: dict[str, Scenario]
    records: dict[str, Played]

    @property
    def tacho(self) -> bool:
        """Whether the controller's own speed is recorded: the rectified sensor exists there only."""
        return any(effect.id == TACHO for effect in self.drawn.hidden)

    @property
    def input_name(self) -> str:
        """Column that drives the model."""
        return "current_ref_A" if {e.id for e in self.drawn.hidden} & CURRENT_PORT else "current_A"


def _make(case: Case, condition: Condition, generator: np.random.Generator) -> Made:
    session = _play_session(condition, case.id, generator)
    noise = draw_noise(condition.noise, generator)
    columns = {
        label: one.columns | {SPEED: noise.add(one.columns[SPEED], one.clean_speed, generator)}
        for label, one in session.records.items()
    }
    test = session.records["test0"]
    answer = _answer(case, session, rms(columns["test0"][SPEED] - test.clean_speed), noise)
    question = Question(
        model=nameplate(session),
        step_s=TICK_S,
        records=columns,
        metadata={} if session.tacho else {"speed": describe_speed("position_rad", TICK_S, DEFAULT_OPTIONS)},
    )
    return Made(question=question, answer=answer, clean_test=test.clean_speed)


def _play_session(condition: Condition, name: str, generator: np.random.Generator) -> Session:
    drawn = draw_case(condition, name, generator)
    session = Session(drawn=drawn, rig=_draw_rig(condition, generator), scenarios={}, records={})
    stop = next((e.complete_parameters for e in drawn.hidden if e.id == "end_stop"), None)
    for label, reference in _references(condition, stop is not None, generator):
        scenario = _scenario((*drawn.hidden, *drawn.held), session.rig, generator)
        played = play(scenario, reference, tacho=session.tacho)
        if stop is not None and max(_at_stops(stop, played).values()) < LEAST_AT_STOP:
            raise UnusableRunError("the end stop is not reached")
        session.scenarios[label], session.records[label] = scenario, played
    return session


def _draw_rig(condition: Condition, generator: np.random.Generator) -> RigConstants:
    """Return the documented rig with a joint friction that the nameplate does not know to better than 20 %."""
    plain = MechanicsConstants()
    friction = plain.joint_viscous_friction_nm_s_rad * float(generator.uniform(0.8, 1.2))
    quantised = condition.noise is Noise.QUANTISED
    sensors = (
        SensorConstants(current_noise_a=0.0, potentiometer_noise_lsb=0.0) if quantised else SensorConstants()
    )
    mechanics = plain.model_copy(update={"joint_viscous_friction_nm_s_rad": friction})
    return RigConstants(mechanics=mechanics, sensors=sensors)


def _scenario(effects: Iterable[Effect], rig: RigConstants, generator: np.random.Generator) -> Scenario:
    """Return a sealed rig with sensor noise of its own, which starts a hair from where the others do."""
    start = float(generator.normal(0.0, 1e-3))
    mechanics = rig.mechanics.model_copy(update={"initial_position_rad": start})
    return Scenario(
        name="blind",
        seed=int(generator.integers(2**40)),
        rig=rig.model_copy(update={"mechanics": mechanics}),
        effects=tuple(effects),
        sealed=True,
    )


def _references(
    condition: Condition, wide: bool, generator: np.random.Generator
) -> list[tuple[str, FloatArray]]:
    """Return label and reference of each record; the test is always rich. `wide` ones reach end stops."""
    rich = excitation.sweeping if wide else excitation.rich
    if condition.training is Training.SINE:
        train = excitation.wide_sine() if wide else excitation.sine()
    else:
        train = rich(generator)
    once = condition.training is Training.SINGLE
    once |= condition.training is Training.DRAWN and bool(generator.integers(2))
    repeats = [("train0", train)] if once else [("train0", train), ("train1", train)]
    return [*repeats, ("test0", rich(generator))]


def _at_stops(stop: dict[str, float], played: Played) -> dict[str, float]:
    """Return the shares of a record that are spent beyond the upper and the lower stop."""
    return {
        "high": float(np.mean(played.true_position > stop["upper_rad"])),
        "low": float(np.mean(played.true_position < stop["lower_rad"])),
    }


def nameplate(session: Session) -> Json:
    """Return the model file's content: inertia known, friction and torque constant as the nameplate has them.

    Where the controller's own speed is the output, its documented observer (two poles at 10 Hz, a delay of 32 ms)
    stands in the model as a known lag.
    """
    held = {effect.id: _truth(session, effect).parameters for effect in session.drawn.held}
    if session.tacho:
        held["speed_filter_lag"] = {"time_constant": 2.0 / (2.0 * np.pi * OBSERVER_HZ)}
    inertia = round(joint_figures(session.rig).inertia, 9)
    return {
        "name": "emulated joint",
        "axis": "rotary",
        "input": session.input_name,
        "outputs": [SPEED],
        "parameters": {
            "inertia": {"value": inertia, "unit": "kg m^2", "fixed": True},
            "viscous_friction": {"value": NAMEPLATE_VISCOUS, "unit": "N m s/rad"},
            "torque_constant": {"value": NAMEPLATE_CONSTANT, "unit": "N m/A"},
        },
        "effects": [
            {"id": name, "parameters": {key: {"value": value} for key, value in values.items()}}
            for name, values in held.items()
        ],
    }


def _truth(session: Session, effect: Effect) -> Truth:
    """Return an effect's true values, without end stops that no training record reached."""
    truth = true_values(effect, joint_figures(session.rig))
    if effect.id != "end_stop":
        return truth
    shares = _at_stops(effect.complete_parameters, session.records["train0"])
    known = {
        name: value for name, value in truth.parameters.items() if shares.get(name, 1.0) >= LEAST_AT_STOP
    }
    return Truth(parameters=known)


def _answer(case: Case, session: Session, noise_rms: float, noise: AddedNoise) -> Answer:
    hidden = session.drawn.hidden
    truths = {effect.id: _truth(session, effect) for effect in hidden}
    gaps = {effect.id: _gap_without(session, {effect.id}) for effect in hidden}
    return Answer(
        condition=case.condition,
        id=case.id,
        seed=case.seed,
        hidden=[effect.id for effect in hidden],
        scenario=[effect.model_dump() for effect in hidden],
        held=[effect.id for effect in session.drawn.held],
        truth={name: truth.parameters for name, truth in truths.items()},
        derived={name: truth.derived for name, truth in truths.items()},
        gap={name: gap / noise_rms for name, (gap, _) in gaps.items()},
        gap_recalibrated={name: left / noise_rms for name, (_, left) in gaps.items()},
        gap_total=_gap_without(session, set(truths))[0] / noise_rms if truths else 0.0,
        noise_rms=noise_rms,
        notes={
            "added_noise": noise.text,
            "training_records": float(len(session.records) - 1),
            "viscous_friction": joint_figures(session.rig).viscous,
        },
    )


def _gap_without(session: Session, removed: set[str]) -> tuple[float, float]:
    """Return the gap on the test record, rad/s, of these effects: plain, and after recalibration.

    The same reference is played again without them, on a rig that is otherwise the same down to its noise. Centring is
    off: its part of the reference is in what is played.
    """
    scenario, shown = session.scenarios["test0"], session.records["test0"]
    effects = tuple(effect for effect in scenario.effects if effect.id not in removed)
    bare = play(
        scenario.model_copy(update={"effects": effects}), shown.command, tacho=session.tacho, centring=False
    )
    figures = joint_figures(session.rig)
    joint = Linear(
        inertia=figures.inertia, viscous=figures.viscous, constant=NAMEPLATE_CONSTANT, step_s=TICK_S
    )
    name = session.input_name
    return gap_of(joint, (shown.clean_speed, bare.clean_speed), (shown.columns[name], bare.columns[name]))
