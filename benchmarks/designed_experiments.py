"""Rig time until the answer is certain: designed experiments against random ones within the same limits.

Each case hides one effect in the emulated controller's physics (without its pseudo-terminal, for speed), beside what a
first recording session has: a sine of 0.5 A for 10 s, played twice, and a test record. Three arms then play one record
after the other and ask again after each. The designed arm plays what the answer proposes. The random arm plays a
record of a kind, amplitude, offset, pace and length (2 to 80 s, evenly in its logarithm) drawn from all that a campaign
can play, the rig's limits admit and the design chooses from. The `length` arm draws the same, but is given the length
of the designed arm's record of that round: how much of the gain is the length. An answer is certain when it names the
hidden effect and nothing else, declares no equivalents but those with the same equations, and leaves nothing open that
a record could settle (what `--resolve` calls settled). An answer that is not certain and proposes nothing makes the
designed arm play a random record of 5 s. An arm that has not ended after BUDGET_S, or after RECORDS records, is
stopped: the designed arm then counts with the whole budget, the others with what they have spent, so that neither rule
flatters the design.

The seeds stand here since before anything was run on them; those from 31,000,000, 33,000,000, 37,000,000,
41,000,000 and 42,000,000 are spent, of those from 34,000,000 and from 36,000,000 the first seven, and of those from
35,000,000 the first 13; the next scoring is from 44,000,000. Those from 39,000,000 are for developing.
Finished cases are kept in OUT and skipped by the next call.

Run: python -m benchmarks.designed_experiments OUT [SECONDS [FIRST_SEED]]   (SECONDS of CPU after which no further case
begins; another first seed to develop on)
"""

import json
import sys
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import TypeAdapter

from benchmarks.blind.draw import draw_parameters
from benchmarks.blind.excitation import TICK_S, rich, sine
from benchmarks.blind.rig import UnusableRunError, play
from benchmarks.random_excitation import random_excitation
from daq.excitation.waveform import sample_reference
from daq.recording.recording import Recording, recording_from_columns
from discrepancy.design.excitations import RAMP_S
from discrepancy.design.limits import RigLimits
from discrepancy.design.question import relative_errors
from discrepancy.model.reader import read_model
from discrepancy.result import GapResult
from discrepancy.search.same import exact_equivalents
from discrepancy.workflow import GapOptions, run_gap
from mock_dsp.scenario.schema import Effect, Scenario
from server.config.excitation import Excitation
from server.services.loading import load_rig
from server.services.rehearsal import design_limits

ROOT = Path(__file__).parents[1]
FIRST_SEED = 44_000_000
SEEDS = 3
EFFECTS = {
    "stribeck_friction": 0.3,
    "gravity_unbalance": 0.3,
    "quadratic_drag": 0.3,
    "load_dependent_friction": 0.5,
    "torque_ripple": 1.0,
    "asymmetric_viscous_friction": 0.3,
    "speed_filter_lag": 0.3,
    "viscous_friction_drift": 1.0,
}
"""Hidden effects and the part of the drawn strength: weak enough that the first session leaves something open."""
SESSION_S = 10.0
SESSION_SHARE = 0.625
LOGGED = 10
"""Ticks of 0.4 ms that one recorded sample averages: a third of the processor time of full rate."""
BUDGET_S = 80.0
RECORDS = 6
UNASKED_S = 5.0
LENGTHS_S = (2.0, 80.0)
ARMS = ("designed", "random", "length")
BOOTSTRAP = 2000

Words = Mapping[str, Any]  # Any: values of a campaign's keys
FloatArray = NDArray[np.float64]


class Case:
    """One hidden effect with its rig, and the records that have been played on it."""

    def __init__(self, name: str, seed: int, limits: RigLimits) -> None:
        self.name, self.limits = name, limits
        generator = np.random.default_rng(seed)
        self.effect = Effect(id=name, parameters=draw_parameters(name, generator, EFFECTS[name]))
        self.generator = generator
        self.noise = seed
        n = round(SESSION_S / TICK_S)
        self.first = [self.record(SESSION_SHARE * sine()[:n]) for _ in range(2)]
        self.test = self.record(rich(np.random.default_rng(seed + 1))[: 2 * n])

    def record(self, reference: FloatArray) -> Recording:
        """Play a reference on the hidden rig; sensor noise is new in every record."""
        self.noise += 1
        scenario = Scenario(name="hidden", seed=self.noise, effects=(self.effect,), sealed=True)
        columns = play(scenario, reference).columns
        rows = columns["time_s"].size // LOGGED * LOGGED
        logged = {name: values[:rows].reshape(-1, LOGGED).mean(axis=1) for name, values in columns.items()}
        return recording_from_columns(logged, sample_time_s=LOGGED * TICK_S)

    def draw(self, duration_s: float) -> Recording:
        """Play a random excitation that the rig takes."""
        while True:
            excitation = {**random_excitation(self.generator, self.limits.amplitude), "ramp_s": RAMP_S}
            if not self.limits.allows(excitation, duration_s):
                continue
            try:
                return self.record(reference(excitation, duration_s))
            except UnusableRunError:
                continue

    def ask(self, extra: list[Recording]) -> GapResult:
        """Return the answer to all records so far."""
        model = read_model(ROOT / "config" / "models" / "joint1.yaml")
        result = run_gap(model, [*self.first, *extra], [self.test], GapOptions(limits=self.limits))
        told = [f"{error:.1%}" for error in errors_of(result).values()]
        print(
            "  ", len(extra), result.verdict, *result.effects, result.steps[-1].equivalents, *told, flush=True
        )
        return result


def reference(words: Words, duration_s: float) -> FloatArray:
    """Return the current that the controller would play, A at every tick."""
    spec = TypeAdapter(Excitation).validate_python(dict(words)).to_spec(duration_s)
    return sample_reference(spec, np.arange(round(duration_s / TICK_S)), round(1.0 / TICK_S))


def certain(result: GapResult, name: str) -> bool:
    """Return whether the answer is the hidden effect alone, and no record would settle anything more."""
    if result.verdict != "named" or result.effects != (name,):
        return False
    if set(result.steps[-1].equivalents) - set(exact_equivalents(result.effects)):
        return False
    entry = result.next_experiment
    return entry is None or not entry["excitation"]


def errors_of(result: GapResult) -> dict[str, float]:
    """Return the relative standard errors of the last effect's parameters."""
    known = result.steps[-1].parameters
    errors = {n: q.std for n, q in known.items() if not q.fixed and q.std is not None}
    return relative_errors({n: q.value for n, q in known.items()}, errors)


def run_case(name: str, seed: int, limits: RigLimits) -> dict[str, Any] | None:
    """Return rig time of all arms and what they played; None if the first session is already certain."""
    designed = Case(name, seed, limits)
    first = designed.ask([])
    if certain(first, name):
        return None
    told: dict[str, Any] = {"effect": name, "seed": seed, "first": [first.verdict, *first.effects]}
    lengths = _designed_arm(designed, first, told)
    told["random"] = _random_arm(Case(name, seed, limits), None)
    told["length"] = _random_arm(Case(name, seed, limits), lengths)
    return told


def _designed_arm(case: Case, result: GapResult, told: dict[str, Any]) -> list[float]:
    records: list[Recording] = []
    lengths: list[float] = []
    played: list[str] = []
    kept: list[Words] = []
    while not certain(result, case.name) and sum(lengths) < BUDGET_S and len(records) < RECORDS:
        entry = result.next_experiment
        excitation = {} if entry is None else entry["excitation"]
        duration = float(entry["duration_s"]) if entry is not None and excitation else UNASKED_S
        duration = min(duration, BUDGET_S - sum(lengths))
        records.append(_played(case, excitation, duration))
        lengths.append(duration)
        played.append(str(excitation.get("kind", "random")))
        result = case.ask(records)
        kept += compared(entry, result)
    told["designed"] = {
        "s": sum(lengths),
        "certain": certain(result, case.name),
        "played": played,
        "lengths": lengths,
        "kept": kept,
    }
    return lengths


def compared(entry: Words | None, result: GapResult) -> list[Words]:
    """Return what was predicted of each parameter's error and what came of it, where the names stayed."""
    if entry is None:
        return []
    reached = errors_of(result)
    return [
        {**one, "reached": reached[one["parameter"]]}
        for one in entry.get("predicted", ())
        if result.effects == (one["effect"],) and one["parameter"] in reached
    ]


def _played(case: Case, excitation: Words, duration_s: float) -> Recording:
    if not excitation:
        return case.draw(duration_s)
    try:
        return case.record(reference(excitation, duration_s))
    except (
        UnusableRunError
    ):  # the hidden effect moves the joint further than the rivals predict: the rig trips
        return case.draw(duration_s)


def _random_arm(case: Case, lengths: list[float] | None) -> dict[str, Any]:
    """Play random records, of lengths drawn too or of these."""
    records: list[Recording] = []
    spent, done = 0.0, False
    while not done and spent < BUDGET_S and len(records) < RECORDS:
        drawn = float(np.round(np.exp(case.generator.uniform(*np.log(LENGTHS_S)))))
        duration = drawn if lengths is None else lengths[min(len(records), len(lengths) - 1)]
        duration = min(duration, BUDGET_S - spent)
        records.append(case.draw(duration))
        spent += duration
        done = certain(case.ask(records), case.name)
    return {"s": spent, "certain": done, "records": len(records)}


def summarise(cases: list[dict[str, Any]]) -> list[str]:
    """Return the table and the median ratio with its bootstrap interval."""
    lines = [
        "| hidden | seed | first answer | designed s | random s | random, same lengths s | played |",
        "|---|---|---|---|---|---|---|",
    ]
    for one in cases:
        times = " | ".join(_time(one[arm]) for arm in ARMS)
        first, played = " ".join(one["first"]), ", ".join(one["designed"]["played"])
        lines.append(f"| {one['effect']} | {one['seed']} | {first} | {times} | {played} |")
    for arm in ARMS[1:]:
        settled = [one for one in cases if one["designed"]["certain"] or one[arm]["certain"]]
        lines += _ratios(cases, arm, "all cases")
        lines += _ratios(settled, arm, "where an arm became certain")
    for arm in ARMS:
        count, total = sum(one[arm]["certain"] for one in cases), sum(one[arm]["s"] for one in cases)
        lines.append(f"{arm}: certain {count} of {len(cases)}, rig time in all {total:g} s")
    pairs = [(k["reached"] / k["relative_std"]) for one in cases for k in one["designed"].get("kept", ())]
    if pairs:
        low, middle, high = np.quantile(pairs, [0.1, 0.5, 0.9])
        lines.append(
            f"standard error reached over predicted: median {middle:.2f} (10 to 90 %: {low:.2f} to {high:.2f}), "
            f"{len(pairs)} parameters"
        )
    return lines


def _ratios(cases: list[dict[str, Any]], arm: str, which: str) -> list[str]:
    """Return the median ratio of rig times, the designed arm's over another's, with its bootstrap interval."""
    ratios = np.array([_counted(one["designed"]) / one[arm]["s"] for one in cases])
    if not ratios.size:
        return []
    draws = np.random.default_rng(0).choice(ratios, size=(BOOTSTRAP, ratios.size))
    low, high = np.quantile(np.median(draws, axis=1), [0.025, 0.975])
    return [
        f"designed / {arm}, {which}: median ratio {np.median(ratios):.2f} (95 % {low:.2f} to {high:.2f}), "
        f"{ratios.size} cases"
    ]


def _counted(designed: Words) -> float:
    return float(designed["s"]) if designed["certain"] else BUDGET_S


def _time(arm: Words) -> str:
    return f"{arm['s']:g}" if arm["certain"] else f"> {arm['s']:g}"


def main(out: Path, most_s: float, first_seed: int = FIRST_SEED) -> None:
    """Run what is not finished and print the table."""
    out.mkdir(parents=True, exist_ok=True)
    limits = design_limits(load_rig(ROOT / "config" / "rigs" / "emulated.yaml"))
    for k in range(SEEDS):
        for j, name in enumerate(EFFECTS):
            seed = first_seed + 1000 * j + 100 * k
            path = out / f"{name}-{seed}.json"
            if path.exists() or time.process_time() > most_s:
                continue
            path.write_text(json.dumps(run_case(name, seed, limits)), encoding="utf-8")
            print(path.name, f"{time.process_time():.0f} s CPU", flush=True)
    answers = [json.loads(path.read_text(encoding="utf-8")) for path in sorted(out.glob("*.json"))]
    print("\n".join(summarise([one for one in answers if one is not None])))
    print(
        f"{sum(one is None for one in answers)} of {len(answers)} cases were certain after the first session"
    )


if __name__ == "__main__":
    given = sys.argv[2:]
    main(
        Path(sys.argv[1]),
        float(given[0]) if given else float("inf"),
        int(given[1]) if len(given) > 1 else FIRST_SEED,
    )
