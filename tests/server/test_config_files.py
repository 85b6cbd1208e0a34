"""Configuration files: those shipped load, and each mistake is named with file, line and field."""

from pathlib import Path

import pytest

from server.config.campaign import Campaign, RecordStep
from server.config.load import load_model
from server.config.rig import Rig
from server.errors import InputError

CONFIG = Path(__file__).resolve().parents[2] / "config"
GOOD = """\
name: trial
steps:
  - record:
      name: first
      duration_s: 20 s
      excitation: {kind: sine, amplitude_A: 400 mA, period_s: 5}
  - identify: {train: first, test: first}
"""


@pytest.mark.parametrize("path", sorted((CONFIG / "campaigns").glob("*.yaml")), ids=lambda path: path.stem)
def test_each_campaign_that_is_shipped_loads(path: Path) -> None:
    assert load_model(path, Campaign).name == path.stem


@pytest.mark.parametrize("path", sorted((CONFIG / "rigs").glob("*.yaml")), ids=lambda path: path.stem)
def test_each_rig_that_is_shipped_loads(path: Path) -> None:
    assert load_model(path, Rig).name == path.stem


def test_units_in_a_campaign_are_converted(tmp_path: Path) -> None:
    path = tmp_path / "campaign.yaml"
    path.write_text(GOOD)
    step = load_model(path, Campaign).steps[0]
    assert isinstance(step, RecordStep)
    assert (step.duration_s, step.excitation.model_dump()["amplitude_A"]) == (20.0, pytest.approx(0.4))


@pytest.mark.parametrize(
    ("right", "wrong", "message"),
    [
        (
            "amplitude_A",
            "amplitud_A",
            ':6: steps[0].record.excitation.amplitud_A: unknown key "amplitud_A"; did ',
        ),
        ("amplitude_A", "amplitud_A", 'did you mean "amplitude_A"?'),
        (
            "400 mA",
            "400 mV",
            ":6: steps[0].record.excitation.amplitude_A: '400 mV' is in mV; allowed here: A, mA",
        ),
        ("400 mA", "40 A", "amplitude_A: '40 A' must be less than or equal to 4"),
        ("kind: sine", "kind: sin", '"sin" is not known; did you mean "sine"? allowed: sine, trapezoid'),
        ("kind: sine, ", "", "steps[0].record.excitation: the key 'kind' is required and missing"),
        ("20 s", "-3", ":5: steps[0].record.duration_s: -3 must be greater than 0"),
        ("period_s: 5", "period_s: .inf", "period_s: inf must be a finite number"),
        ("record:", "recrd:", ':3: steps[0]: unknown step "recrd"; did you mean "record"?'),
        ("identify: {", "gap: {", ":7: steps[1].gap.model: this key is required and missing"),
        (
            "identify: {train: first, ",
            "gap: {model: m.yaml, train: [first, secnd], ",
            ':7: steps[1].gap.train: no record step before this one is called "secnd"',
        ),
        (
            "identify: {train: first, ",
            "gap: {model: m.yaml, train: [], ",
            ":7: steps[1].gap.train: []",
        ),
        (
            "train: first",
            "train: frist",
            ":7: steps[1].identify.train: no record step before this one is called",
        ),
        ("name: trial", "name: trial\nname: again", ":2: name: this key stands twice; keep one"),
        ("name: trial\n", "", "name: this key is required and missing"),
        ("name: trial", "name: [1]", "name: [1] must be a valid string"),
        ("period_s: 5}", "period_s: 5", "not valid YAML"),
        ("      duration_s: 20 s\n", "", "steps[0].record.duration_s: this key is required and missing"),
        (GOOD, "- 1\n", "must hold keys and values"),
        (GOOD, "", "must hold keys and values"),
    ],
)
def test_a_mistake_in_a_campaign_is_named(tmp_path: Path, right: str, wrong: str, message: str) -> None:
    path = tmp_path / "campaign.yaml"
    path.write_text(GOOD.replace(right, wrong, 1))
    with pytest.raises(InputError) as caught:
        load_model(path, Campaign)
    assert str(caught.value).startswith(str(path))
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("right", "wrong", "message"),
    [
        ("baud: 937500", "baud: 12", "link.baud: 12 must be greater than or equal to 9600"),
        (
            "speed_rad_s: 180.0",
            "speed_rad_s: 180 N",
            "limits.speed_rad_s: '180 N' is in N; allowed here: rad/s",
        ),
        ("calibration: {}", "calibration: {current_A: {}}", "give scale, offset_counts or both"),
        ("scenario: ../scenarios/nominal.yaml", "", 'link.url "emulate" needs the key scenario'),
        (
            "inertia_kg_m2: 0.5 ",
            "inertia_kg_m2: -0.5 ",
            "nameplate.inertia_kg_m2: -0.5 must be greater than 0",
        ),
    ],
)
def test_a_mistake_in_a_rig_file_is_named(tmp_path: Path, right: str, wrong: str, message: str) -> None:
    text = (CONFIG / "rigs" / "emulated.yaml").read_text()
    assert right in text
    path = tmp_path / "rig.yaml"
    path.write_text(text.replace(right, wrong, 1))
    with pytest.raises(InputError) as caught:
        load_model(path, Rig)
    assert message in str(caught.value)


def test_a_missing_file_names_one_that_is_there(tmp_path: Path) -> None:
    (tmp_path / "paper.yaml").write_text("")
    with pytest.raises(InputError, match=r'no such file; did you mean "paper.yaml"'):
        load_model(tmp_path / "papper.yaml", Campaign)


def test_yaml_that_would_build_objects_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "campaign.yaml"
    path.write_text("name: !!python/object/apply:os.getcwd []\n")
    with pytest.raises(InputError, match="not valid YAML"):
        load_model(path, Campaign)


def test_each_key_of_a_shipped_rig_file_has_a_comment() -> None:
    lines = (CONFIG / "rigs" / "emulated.yaml").read_text().splitlines()
    bare = [
        line
        for line in lines
        if ":" in line and "#" not in line and not line.rstrip().endswith(":") and "_ohm" not in line
    ]
    # What stands below `physics: motor:` is explained in config/motors/joint1.yaml, which that line names.
    assert [line.strip() for line in bare if line.startswith("  ") and not line.startswith("    ")] == []
