"""docs/effects.md and its pictures are what the table of effects generates, and show what they say."""

import re
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest

from discrepancy.effects import document
from discrepancy.effects.pictures.joint import INERTIA
from discrepancy.effects.pictures.spec import Line, Picture
from discrepancy.effects.pictures.svg import write_svg
from discrepancy.effects.pictures.table import PICTURES
from discrepancy.effects.table import EFFECTS

DOCS = Path(__file__).parents[3] / "docs"
REMEDY = "run: python -m discrepancy.effects.document docs"
LARGEST_BYTES = 40_000
LAST_DIGIT_PT = 0.05
_NUMBER = re.compile(r"-?\d+(?:\.\d+)?")
_NAME = re.compile(r' (?:id|xlink:href|clip-path)="[^"]*"')


def picture_of(name: str) -> Picture:
    return PICTURES[name](EFFECTS[name])


def lines_of(name: str, panel: int = 0) -> dict[str, Line]:
    return {line.name: line for line in picture_of(name).panels[panel].lines}


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("docs")
    document.write_document(folder)
    return folder


def words_and_numbers(file: Path) -> tuple[str, list[float]]:
    """Return a picture's text without its numbers and the names that are made of them, and the numbers."""
    text = _NAME.sub("", file.read_text(encoding="utf-8"))
    return _NUMBER.sub("#", text), [float(number) for number in _NUMBER.findall(text)]


def test_page_is_generated_from_the_table(written: Path) -> None:
    assert (written / "effects.md").read_bytes() == (DOCS / "effects.md").read_bytes(), REMEDY


@pytest.mark.parametrize("name", EFFECTS)
def test_picture_is_generated_from_the_table(name: str, written: Path) -> None:
    (words, numbers), (known_words, known) = (
        words_and_numbers(folder / "effects" / f"{name}.svg") for folder in (written, DOCS)
    )
    assert words == known_words, REMEDY
    # Another processor may compute another last digit.
    assert np.allclose(numbers, known, rtol=0.0, atol=LAST_DIGIT_PT), REMEDY


@pytest.mark.parametrize("name", EFFECTS)
def test_picture_has_a_title_units_and_finite_lines(name: str) -> None:
    picture = picture_of(name)
    assert picture.values.keys() == {parameter.name for parameter in EFFECTS[name].parameters}
    for panel in picture.panels:
        assert ", " in panel.x
        assert ", " in panel.y
        for line in panel.lines:
            assert line.x.shape == line.y.shape
            assert np.all(np.isfinite(line.x)) and np.all(np.isfinite(line.y))


def test_folder_holds_one_small_svg_file_for_each_effect_and_nothing_else() -> None:
    found = {path.name: path.stat().st_size for path in (DOCS / "effects").iterdir()}
    assert found.keys() == {f"{name}.svg" for name in EFFECTS}
    assert max(found.values()) < LARGEST_BYTES


def test_picture_tells_neither_date_nor_program_and_is_well_formed() -> None:
    text = write_svg(picture_of("coulomb_friction"))
    assert "metadata" not in text
    assert ElementTree.fromstring(text).tag.endswith("svg")


def test_command_names_the_folder_that_it_cannot_write(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    taken = tmp_path / "taken"
    taken.write_text("a file")
    monkeypatch.setattr(sys, "argv", ["document", str(taken)])
    with pytest.raises(SystemExit) as ended:
        document.main()
    assert ended.value.code == 1
    assert str(taken) in capsys.readouterr().err


def test_coulomb_friction_steps_at_zero_speed_from_level_to_level() -> None:
    level = picture_of("coulomb_friction").values["level"]
    line = lines_of("coulomb_friction")[""]
    assert np.all(line.y[line.x > 0.0] == pytest.approx(level))
    assert np.all(line.y[line.x < 0.0] == pytest.approx(-level))


def test_load_dependent_friction_has_the_same_size_driving_and_braking() -> None:
    coefficient = picture_of("load_dependent_friction").values["coefficient"]
    for name, sign in (("w > 0", 1.0), ("w < 0", -1.0)):
        line = lines_of("load_dependent_friction")[name]
        assert line.y == pytest.approx(sign * coefficient * np.abs(line.x), abs=1e-12)


@pytest.mark.parametrize("exponent", [1, 2, 3])
def test_presliding_friction_closes_a_loop_that_takes_energy(exponent: int) -> None:
    line = lines_of("presliding_hysteresis")[f"exponent {exponent}"]
    assert np.trapezoid(line.y, line.x) > 0.0
    assert np.max(np.abs(line.y)) <= picture_of("presliding_hysteresis").values["level"]


def test_shaft_carries_nothing_inside_the_gap_and_pushes_beyond() -> None:
    values, line = picture_of("backlash").values, lines_of("backlash")[""]
    beyond = np.abs(line.x) - 0.5 * values["gap"]
    expected = np.sign(line.x) * values["stiffness"] * np.maximum(0.0, beyond)
    assert line.y == pytest.approx(expected, abs=1e-9)


def test_belt_responds_least_at_the_anti_resonance_and_most_at_the_resonance() -> None:
    values, line = picture_of("belt_compliance").values, lines_of("belt_compliance", panel=1)["motor"]
    share, inertia = values["load_share"], INERTIA
    least = np.sqrt(values["stiffness"] / (share * inertia)) / (2.0 * np.pi)
    most = least / np.sqrt(1.0 - share)
    near = (line.x > 5.0) & (line.x < 30.0)
    # The points of the picture are 3 % apart.
    assert line.x[near][np.argmin(line.y[near])] == pytest.approx(least, rel=0.04)
    assert line.x[near][np.argmax(line.y[near])] == pytest.approx(most, rel=0.04)


def test_current_behind_a_lag_has_made_63_percent_of_a_step_after_its_time_constant() -> None:
    line = lines_of("current_loop_lag")["current"]
    value = np.interp(0.05 + picture_of("current_loop_lag").values["time_constant"], line.x, line.y)
    assert value / np.max(line.y) == pytest.approx(1.0 - np.exp(-1.0), abs=0.01)
