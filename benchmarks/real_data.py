"""What the discrepancy workflow finds in data that others measured, and how its torque limits were chosen.

    python -m benchmarks.real_data                 the limits, on splits of the training records
    python -m benchmarks.real_data final           one run on the test records

Each limit of `discrepancy.torque.limits` is varied alone. Every training record is cut into halves; each half names
effects, the other judges them. A limit is good if both halves and the whole record get the same names, and if the
names predict the other half. No test record is opened by the first command. The data are not part of the project:
`JOINTSCOPE_SHARED_DATA`, or `../shared/data` beside the repository.
"""

import os
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.real_data_cases import Case, Records, emps, torque_cases
from discrepancy.data.series import read_series
from discrepancy.errors import GapInputError
from discrepancy.fitting.parameters import model_vector
from discrepancy.fitting.problem import Noise, SimulationProblem
from discrepancy.model.schema import Judge, Quantity
from discrepancy.result import GapResult
from discrepancy.torque.limits import TorqueLimits
from discrepancy.workflow import GapOptions, run_gap

DATA = Path(os.environ.get("JOINTSCOPE_SHARED_DATA", Path(__file__).parents[2] / "shared" / "data"))
VARIED = {
    "material_rms": (0.03, 0.06, 0.25),
    "form_error": (0.02, 0.05, 0.2),
    "rest_share": (0.005, 0.05, 0.1),
    "differentiation_factor": (2.0, 5.0),
    "band_factor": (8.0, 32.0),
}
SHORT = {
    "coulomb_friction": "C", "load_torque_offset": "o", "current_sensor_offset": "o", "gravity_unbalance": "g",
    "asymmetric_viscous_friction": "av", "load_dependent_friction": "L", "presliding_hysteresis": "P",
    "stribeck_friction": "S", "position_dependent_inertia": "J", "torque_ripple": "R", "quadratic_drag": "Q",
}  # fmt: skip


def main(arguments: Sequence[str]) -> int:
    """Print the split experiments, or with `final` the test records' figures."""
    if not (DATA / "emps").is_dir():
        print(f"measured data are not part of the project; none in {DATA} (set JOINTSCOPE_SHARED_DATA)")
        return 0
    if list(arguments) == ["final"]:
        final_run()
    else:
        split_table()
    return 0


def settings() -> list[tuple[str, TorqueLimits]]:
    """Return the limits in force and each variation of one of them."""
    base = TorqueLimits()
    varied = [
        (f"{name} {value:g}", replace(base, **{name: value}))
        for name, values in VARIED.items()
        for value in values
    ]
    return [("in force", base), *varied]


def split_table() -> None:
    """Print names and held-out errors of both halves of every training record, for each setting.

    Without the XL330: its two training runs are of different kinds and share no law that either shows alone.
    """
    cases = torque_cases(DATA)[:3]
    print(f"{'':28}" + "".join(f"{case.name:>34}" for case in cases))
    for name, limits in settings():
        began = time.process_time()
        cells = [_cell(case, limits) for case in cases]
        print(
            f"{name:28}" + "".join(f"{cell:>34}" for cell in cells) + f"{time.process_time() - began:7.0f} s",
            flush=True,
        )


def _cell(case: Case, limits: TorqueLimits) -> str:
    names, errors = [], []
    for train, judge in case.splits:
        verdict, error = _judge(case, train, judge, limits)
        names.append(verdict)
        errors.append(error)
    return f"{' | '.join(names)} {100 * errors[0]:.1f} {100 * errors[1]:.1f}"


def _judge(case: Case, train: Records, judge: Records, limits: TorqueLimits) -> tuple[str, float]:
    """Return short names (with ? where the verdict is unknown) and the error on the other part."""
    try:
        result = run_gap(case.model, train, judge, GapOptions(torque=limits))
    except GapInputError:
        return "refused", float("nan")
    names = " ".join(SHORT.get(name, name) for name in result.effects) or "-"
    return names + ("?" if result.verdict == "unknown" else ""), last_error(result)


def last_error(result: GapResult) -> float:
    """Return rms error over the signal's standard deviation of the last model."""
    return float(np.mean([score.nrmse for score in result.steps[-1].test.values()]))


def final_run() -> None:
    """Name from the whole training records and score on the test records."""
    for case in [*torque_cases(DATA), emps(DATA, "simulation")]:
        began = time.process_time()
        result = run_gap(case.model, case.train, case.test())
        print(f"\n{case.name}: {result.verdict} ({time.process_time() - began:.0f} s of processor time)")
        for step in result.steps:
            for name in step.test:
                train, test = step.train[name], step.test[name]
                print(
                    f"  {step.added or 'base':30}{name:12} train {100 * train.nrmse:7.2f} %  "
                    f"test {100 * test.nrmse:7.2f} %  rms {test.rmse:.4g}   {_values(step.terms)}"
                )
        for note in result.notes:
            print(f"  {note}")
        if case.model.judge_by is Judge.SIMULATION:
            print(f"  from the measured start, nothing fitted to the test: {_as_measured(result, case):.4g}")


def _as_measured(result: GapResult, case: Case) -> float:
    """Return the rms error of a free run from rest at the first measured position of the test record."""
    one = read_series(case.test()[0], case.model, "test")
    vector = model_vector(result.model)
    at_rest = (one.starts * np.array([0.0, 1.0]),)
    problem = SimulationProblem(series=(one,), noise=Noise(sigma={one.channels[0].name: 1.0}))
    left = problem.measured() - problem.flatten(problem.simulate(problem.prepare(vector), at_rest))
    return float(np.sqrt(np.mean(left**2)))


def _values(terms: Mapping[str, Mapping[str, Quantity]]) -> str:
    return ", ".join(
        f"{owner}.{name} {q.value:.3g} ± {q.std or 0.0:.1g}"
        for owner, quantities in terms.items()
        for name, q in quantities.items()
    )


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
