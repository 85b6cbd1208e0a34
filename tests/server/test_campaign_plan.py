"""A campaign is predicted and refused before anything moves."""

from collections.abc import Callable
from pathlib import Path

import pytest

from server.errors import InputError
from server.services.loading import RunChoices, load_plan

CampaignFile = Callable[[str], Path]
CONFIG = Path(__file__).resolve().parents[2] / "config"
SINE = "kind: sine, amplitude_A: 0.5, period_s: 5"
RECORD = """\
  - record:
      name: a
      duration_s: 300
      excitation: {kind: sine, amplitude_A: 0.5, period_s: 5, ramp_s: 1}
"""


def test_the_papers_campaign_stays_within_every_limit() -> None:
    plan = load_plan(RunChoices(campaign=CONFIG / "campaigns" / "paper.yaml"))
    records = [step.record for step in plan.steps if step.record is not None]
    assert plan.duration_s == 2002.0
    assert [record.samples for record in records] == [2_502_500, 2_502_500]
    # Two thirds of the travel: an effect that the nameplate does not know must not trip the drive.
    assert all(record.report.position_min_rad > -20.0 for record in records)
    assert all(record.report.position_max_rad < 20.0 for record in records)


@pytest.mark.parametrize(
    ("right", "wrong", "message"),
    [
        ("amplitude_A: 0.5", "amplitude_A: 2.5", "peak current of 2.5"),
        ("amplitude_A: 0.5", "amplitude_A: 2.5", "exceeds the limit of 2 A; use a smaller amplitude"),
        (SINE, "kind: trapezoid, amplitude_A: 1.95, period_s: 4, rise_fraction: 0.05", "I2t current of"),
        ("amplitude_A: 0.5, period_s: 5", "amplitude_A: 1.2, period_s: 600", "predicted travel of"),
        (
            SINE,
            "kind: prbs, amplitude_A: 1, register_bits: 7, bit_s: 0.5",
            "slew",
        ),
    ],
)
def test_an_excitation_over_a_limit_is_refused_with_number_and_limit(
    campaign_file: CampaignFile, right: str, wrong: str, message: str
) -> None:
    path = campaign_file(RECORD.replace(right, wrong))
    with pytest.raises(InputError) as caught:
        load_plan(RunChoices(campaign=path))
    assert f"{path}:7: steps[0].record.excitation: " in str(caught.value)
    assert message in str(caught.value)


def test_a_set_step_changes_what_later_steps_are_predicted_with(campaign_file: CampaignFile) -> None:
    weaker = "  - set: {parameter: centring_gain_A_rad, value: 0.0}\n"
    plain = load_plan(RunChoices(campaign=campaign_file(RECORD))).steps[-1].record
    uncentred = load_plan(RunChoices(campaign=campaign_file(weaker + RECORD))).steps[-1].record
    assert plain is not None
    assert uncentred is not None
    assert uncentred.report.position_max_rad > plain.report.position_max_rad


def test_a_stream_that_does_not_fit_the_line_is_refused_with_one_that_does(
    campaign_file: CampaignFile, tmp_path: Path
) -> None:
    rig = tmp_path / "slow.yaml"
    text = (CONFIG / "rigs" / "emulated.yaml").read_text()
    rig.write_text(
        text.replace("baud: 937500", "baud: 115200").replace("../scenarios", str(CONFIG / "scenarios"))
    )
    with pytest.raises(
        InputError, match=r"takes 1\d\d% of a line of 115200 Bd, above the 80% allowed; use divisor 2"
    ):
        load_plan(RunChoices(campaign=campaign_file(RECORD), rig=rig))


def test_an_estimator_that_does_not_exist_is_refused_before_anything_is_recorded(
    campaign_file: CampaignFile,
) -> None:
    path = campaign_file(RECORD + "  - identify: {train: a, test: a, methods: [rls, kalman]}\n")
    with pytest.raises(InputError, match=r"steps\[1\].identify.methods: .*'kalman' is not an estimator"):
        load_plan(RunChoices(campaign=path))


def test_ramps_longer_than_the_record_are_refused(campaign_file: CampaignFile) -> None:
    path = campaign_file(RECORD.replace("duration_s: 300", "duration_s: 1.5"))
    with pytest.raises(
        InputError, match=r"ramp_s of 1.0 s fades in and out and needs duration_s of at least 2.0 s"
    ):
        load_plan(RunChoices(campaign=path))


@pytest.mark.parametrize(
    ("choices", "message"),
    [
        ({"speed": "fast"}, '--speed: "fast" is neither max nor a factor up to 1000'),
        ({"emulate": Path("absent.yaml")}, "absent.yaml: no such scenario file"),
        ({"rig": Path("absent.yaml")}, "absent.yaml: no such file"),
    ],
)
def test_choices_that_make_no_sense_are_refused(
    campaign_file: CampaignFile, choices: dict[str, Path], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        load_plan(RunChoices(campaign=campaign_file(RECORD), **choices))  # type: ignore[arg-type]  # one at a time
