"""`jointscope gap --resolve`: rounds, limits and endings, with scripted answers; the rig is the emulated one."""

import json
import threading
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import yaml

from daq.recording.store import read_recording
from discrepancy.design.campaign import campaign
from discrepancy.report.pictures import Detectable, Pictures
from server.cli.main import main
from server.errors import CampaignStoppedError, InputError
from server.services import resolve as service
from server.services.discrepancy import ANSWER_NAMES, EXPERIMENT_NAME, GapAnalysis, GapRequest
from server.services.limits import rig_joint
from server.services.loading import load_rig
from server.services.progress import SilentListener
from server.services.rehearsal import admits, design_limits
from server.services.resolve import Resolution, ResolveRequest, resolve
from tests.server.test_gap_command import gap_result

CONFIG = Path(__file__).resolve().parents[2] / "config"
RIG = CONFIG / "rigs" / "emulated.yaml"
SINE = {"kind": "sine", "amplitude_A": 0.5, "period_s": 2.0, "ramp_s": 0.5}

Plan = dict[str, Any] | None  # Any: values of the JSON object `next_experiment`
Script = Callable[..., list[GapRequest]]


def proposal(duration_s: float = 5.0, **changes: object) -> dict[str, Any]:
    """Return a proposed experiment."""
    return {
        "why": "tells a from b",
        "separates": ["a", "b"],
        "duration_s": duration_s,
        "excitation": {**SINE, **changes},
    }


@pytest.fixture
def script(monkeypatch: pytest.MonkeyPatch) -> Script:
    """Return a function that replaces the analysis by answers with these proposals; it returns what was asked."""

    def play(*plans: Plan) -> list[GapRequest]:
        asked: list[GapRequest] = []

        def answer(request: GapRequest, out: Path, tell: object) -> GapAnalysis:
            plan = plans[len(asked)]
            asked.append(request)
            out.mkdir(parents=True)
            for name in ANSWER_NAMES:
                (out / name).write_text(f"{name} {len(asked)}")
            playable = plan is not None and plan["excitation"]
            if plan is not None and playable:
                (out / EXPERIMENT_NAME).write_text(yaml.safe_dump(campaign(plan)))
            result = replace(gap_result(), next_experiment=plan)
            if plan is not None and "reveals" in plan:
                seen = Detectable(
                    id="coulomb_friction", parameter="level", size=plan["reveals"][0]["now"], unit="N m"
                )
                result = replace(result, verdict="none", pictures=Pictures(detectable=(seen,)))
            return GapAnalysis(
                result=result, folder=out, experiment=out / EXPERIMENT_NAME if playable else None
            )

        monkeypatch.setattr(service, "run_gap_analysis", answer)
        return asked

    return play


def request(**changes: Any) -> ResolveRequest:  # Any: fields of the request
    """Return a question about the emulated rig."""
    gap = GapRequest(model=CONFIG / "models" / "joint1.yaml", train=(Path("a"),), test=(Path("b"),))
    return replace(ResolveRequest(gap=gap, rig=RIG), **changes)


def resolved(question: ResolveRequest, out: Path) -> Resolution:
    """Run the rounds."""
    return resolve(question, out, SilentListener(), threading.Event())[1]


def written(out: Path) -> dict[str, Any]:
    """Return `resolve.json`."""
    content: dict[str, Any] = json.loads((out / "resolve.json").read_text())
    return content


def test_a_proposal_is_played_and_its_record_joins_the_training(script: Script, tmp_path: Path) -> None:
    asked, out = script(proposal(), None), tmp_path / "out"
    done = resolved(request(), out)
    assert done.is_settled
    record = out / "round-0" / "run" / "records" / "next.parquet"
    assert [one.train for one in asked] == [(Path("a"),), (Path("a"), record)]
    assert read_recording(record).duration_s > 4.9
    told = written(out)
    assert (told["ended"], told["rig_time_s"], len(told["rounds"])) == ("settled", 5.0, 2)
    assert (out / "gap.json").read_text() == "gap.json 2"
    assert not (out / EXPERIMENT_NAME).exists()


def look(now: float, then: float) -> dict[str, Any]:
    """Return a proposed look for hidden dry friction, N m."""
    one = {"effect": "coulomb_friction", "parameter": "level", "unit": "N m", "now": now, "then": then}
    return {**proposal(amplitude_A=100.0 * now), "reveals": [one]}


def test_none_after_a_record_that_shows_what_it_was_to_show_is_settled(
    script: Script, tmp_path: Path
) -> None:
    script(look(0.005, 0.002), look(0.002, 0.001))
    done = resolved(request(), tmp_path / "out")
    assert (done.ended, len(done.rounds)) == ("settled", 2)
    assert "has shown none" in done.message


def test_none_after_a_record_that_shows_less_than_stated_looks_again(script: Script, tmp_path: Path) -> None:
    script(look(0.005, 0.002), look(0.004, 0.001), None)
    assert len(resolved(request(), tmp_path / "out").rounds) == 3


def test_a_proposal_beyond_the_rig_file_is_refused_before_anything_moves(
    script: Script, tmp_path: Path
) -> None:
    script(proposal(amplitude_A=3.0))
    with pytest.raises(InputError, match="exceeds the limit"):
        resolved(request(), tmp_path / "out")
    assert written(tmp_path / "out")["ended"] == "refused"
    assert not (tmp_path / "out" / "round-0" / "run").exists()


@pytest.mark.parametrize(
    ("plan", "changes", "ended"),
    [
        (None, {}, "settled"),
        ({"why": "", "separates": [], "excitation": {}, "other_measurements": []}, {}, "measurement"),
        (proposal(), {"rounds": 0}, "rounds"),
        (proposal(), {"budget_s": 4.0}, "budget"),
    ],
)
def test_it_ends_without_a_run(
    plan: Plan, changes: dict[str, Any], ended: str, script: Script, tmp_path: Path
) -> None:
    script(plan)
    assert resolved(request(**changes), tmp_path / "out").ended == ended
    assert written(tmp_path / "out")["ended"] == ended


def test_a_stop_request_ends_it_before_the_rig_moves(script: Script, tmp_path: Path) -> None:
    script(proposal())
    stop = threading.Event()
    stop.set()
    with pytest.raises(CampaignStoppedError):
        resolve(request(), tmp_path / "out", SilentListener(), stop)
    assert written(tmp_path / "out")["ended"] == "interrupted"


def test_an_earlier_call_is_never_written_over(script: Script, tmp_path: Path) -> None:
    script(None, None)
    resolved(request(), tmp_path / "out")
    with pytest.raises(InputError, match="an earlier call"):
        resolved(request(), tmp_path / "out")


@pytest.mark.parametrize(
    ("changes", "duration_s", "taken"),
    [
        ({}, 20.0, True),
        ({"amplitude_A": 2.5}, 20.0, False),
        ({"amplitude_A": 1.9, "period_s": 60.0}, 40.0, False),  # leaves the travel
        (
            {"kind": "prbs", "register_bits": 9, "bit_s": 0.2, "period_s": None},
            20.0,
            False,
        ),  # steeper than the slew
        ({"kind": "magic"}, 20.0, False),
    ],
)
def test_only_what_a_plan_would_take_is_proposed(
    changes: dict[str, Any], duration_s: float, taken: bool
) -> None:
    rig = load_rig(RIG)
    words = {key: value for key, value in {**SINE, **changes}.items() if value is not None}
    assert admits(rig, rig_joint(rig), words, duration_s) is taken
    assert design_limits(rig).allows(words, duration_s) is taken


def test_resolve_without_a_rig_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    model = CONFIG / "models" / "joint1.yaml"
    arguments = [
        "gap",
        "--model",
        model,
        "--train",
        "a",
        "--test",
        "b",
        "--out",
        tmp_path / "out",
        "--resolve",
    ]
    assert main([str(argument) for argument in arguments]) == 2
    assert "--rig" in capsys.readouterr().err
