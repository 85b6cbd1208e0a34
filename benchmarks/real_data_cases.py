"""The measured data sets of `benchmarks.real_data`: base models, training records, their splits, and test records.

Test records are behind a function that only the final run calls: nothing else here opens them.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from daq.exchange.importing import import_file
from daq.recording.recording import Recording, cut
from discrepancy.model.reader import parse_model
from discrepancy.model.schema import JointModel

Records = tuple[Recording, ...]
Document = dict[str, Any]  # Any: what a YAML file would hold


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """One joint.

    Attributes:
        splits: pairs of a part to name from and a part to be judged on, both of the training records.
        test: opens the test records.
    """

    name: str
    model: JointModel
    train: Records
    splits: tuple[tuple[Records, Records], ...]
    test: Callable[[], Records]


def _halves(recording: Recording) -> tuple[tuple[Records, Records], ...]:
    middle, end = 0.5 * recording.duration_s, recording.duration_s + 1.0
    first, second = cut(recording, 0.0, middle), cut(recording, middle, end)
    return ((first,), (second,)), ((second,), (first,))


def emps(data: Path, judge_by: str) -> Case:
    """EMPS by force or by simulated position; the mass is not held, since the input is a force."""
    document: Document = {
        "name": f"emps by {judge_by}", "axis": "linear", "input": "motor_force_N", "outputs": ["position_m"],
        "parameters": {"mass": {"value": 95.0, "unit": "kg"}, "viscous_friction": {"value": 200.0, "unit": "N s/m"}},
        "judge_by": judge_by,
    }  # fmt: skip
    train = import_file(data / "emps" / "emps_train.csv.gz")
    return Case(
        name=str(document["name"]), model=parse_model(document), train=(train,), splits=_halves(train),
        test=lambda: (import_file(data / "emps" / "emps_test_pulses.csv.gz"),),
    )  # fmt: skip


def ur10e(data: Path, joint: int) -> Case:
    """One joint of the UR10e by torque: the first half of the record is for training, the second for the test."""
    document: Document = {
        "name": f"ur10e joint {joint} by torque", "outputs": ["position_rad"], "judge_by": "torque",
        "parameters": {
            "inertia": {"value": 8.0, "unit": "kg m^2"}, "viscous_friction": {"value": 20.0, "unit": "N m s/rad"},
            "torque_constant": {"value": 10.0, "unit": "N m/A", "fixed": True},
        },
    }  # fmt: skip
    path = data / "ur10e" / f"ur10e_joint{joint}.csv"
    train = cut(import_file(path), 0.0, 30.0)
    return Case(
        name=str(document["name"]), model=parse_model(document), train=(train,), splits=_halves(train),
        test=lambda: (cut(import_file(path), 30.0, 100.0),),
    )  # fmt: skip


def xl330(data: Path) -> Case:
    """The XL330 with a pendulum by torque; two runs train (and judge each other), one tests.

    `lift_and_drop` is left out: with the motor switched off its voltage is not the one that was recorded.
    The torque constant is stall torque over voltage of the data sheet, 0.52 N m at 5 V.
    """
    document: Document = {
        "name": "xl330 by torque", "input": "motor_voltage_V", "outputs": ["position_rad"], "judge_by": "torque",
        "parameters": {
            "inertia": {"value": 0.006, "unit": "kg m^2"}, "viscous_friction": {"value": 0.1, "unit": "N m s/rad"},
            "torque_constant": {"value": 0.104, "unit": "N m/V", "fixed": True},
        },
    }  # fmt: skip

    def run(name: str) -> Recording:
        return import_file(data / "xl330_pendulum" / f"xl330_m0.49_l0.1_kp400_{name}.csv")

    first, second = (run("sin_sin"),), (run("up_and_down"),)
    return Case(
        name=str(document["name"]), model=parse_model(document), train=(*first, *second),
        splits=((first, second), (second, first)), test=lambda: (run("sin_time_square"),),
    )  # fmt: skip


def torque_cases(data: Path) -> list[Case]:
    """Return the joints that are judged by torque."""
    return [emps(data, "torque"), ur10e(data, 1), ur10e(data, 3), xl330(data)]
