"""Sealed rigs through the whole chain: emulator, pseudo-terminal, driver, recordings, workflow; then the answer.

The seeds and the limits below were written down before any of them was played, and nothing is tuned on what they show.
The campaign drives the model by the measured current, so effects of the current port cannot show: `none` is no lie
then.
"""

import json
import signal
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from discrepancy.effects.spec import Port
from discrepancy.effects.table import EFFECTS

REPOSITORY = Path(__file__).resolve().parents[2]
CONFIG = REPOSITORY / "config"
SEEDS = tuple(range(20301, 20321))
MOST_LIES = 2
"""Verdicts `named` with a name that is not hidden."""
LEAST_RIGHT = 14
"""Verdicts that name all that is hidden and nothing else, or `none` where nothing is or nothing can show."""
PLAYED_AT_ONCE = 2
DEADLINE_S = 400.0

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def verdicts(
    tmp_path_factory: pytest.TempPathFactory,
) -> dict[int, tuple[dict[str, object], list[str]]]:
    """Play and judge every sealed rig, and only then open the answers: gap.json and the hidden ids by seed."""
    folder = tmp_path_factory.mktemp("sealed")
    with ThreadPoolExecutor(PLAYED_AT_ONCE) as players:
        played = players.map(lambda seed: play_sealed(seed, folder / str(seed)), SEEDS)
        answers = dict(zip(SEEDS, played, strict=True))
    return {seed: (answer, hidden_effects(folder / str(seed))) for seed, answer in answers.items()}


def play_sealed(seed: int, folder: Path) -> dict[str, object]:
    """Run the campaign on a sealed emulator and return the content of gap.json."""
    folder.mkdir()
    port = folder / "controller"
    nominal = CONFIG / "scenarios" / "nominal.yaml"
    emulator = subprocess.Popen(
        [sys.executable, "-m", "mock_dsp", "--scenario", str(nominal), "--link", str(port), "--speed", "max",
         "--sealed", str(seed), "--answer", str(folder / "answer.json")],
        stdout=subprocess.PIPE,
        text=True,
    )  # fmt: skip
    try:
        assert emulator.stdout is not None
        assert "emulated controller on" in emulator.stdout.readline()
        rig = rig_file(folder, port)
        campaign = CONFIG / "campaigns" / "hidden.yaml"
        arguments = map(str, ("run", campaign, "--rig", rig, "--out", folder / "run"))
        command = [sys.executable, "-m", "server", *arguments]
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=DEADLINE_S)
        assert done.returncode == 0, f"seed {seed}: {done.stderr}"
    finally:
        emulator.send_signal(signal.SIGTERM)
        emulator.communicate(timeout=DEADLINE_S)
    answer: dict[str, object] = json.loads((folder / "run" / "gap.json").read_text())
    return answer


def rig_file(folder: Path, port: Path) -> Path:
    """Write a rig file that leads to a port, as for a real controller."""
    path = folder / "rig.yaml"
    text = (CONFIG / "rigs" / "emulated.yaml").read_text()
    path.write_text(text.replace("url: emulate ", f"url: {port} "))
    return path


def hidden_effects(folder: Path) -> list[str]:
    """Open the answer."""
    answer = json.loads((folder / "answer.json").read_text())
    return [effect["id"] for effect in answer["effects"]]


def wrong_names(answer: dict[str, object], hidden: list[str]) -> list[str]:
    """Return the effects that were named, are not hidden, and were not declared equivalent to a hidden one."""
    wrong = []
    for step in answer["steps"]:  # type: ignore[attr-defined]  # JSON
        name = step["added"]
        same = [[one] if isinstance(one, str) else one for one in step["equivalents"]]
        if name is not None and name not in hidden and not any(set(each) <= set(hidden) for each in same):
            wrong.append(name)
    return wrong


def is_right(answer: dict[str, object], hidden: list[str]) -> bool:
    """Whether all that is hidden and can show is named, and nothing else; outside the catalogue `unknown` is right."""
    if any(name not in EFFECTS for name in hidden):
        return answer["verdict"] == "unknown" and not wrong_names(answer, hidden)
    shown = [name for name in hidden if EFFECTS[name].port is not Port.CURRENT]
    named: set[str] = set()
    for step in answer["steps"]:  # type: ignore[attr-defined]  # JSON
        for each in [step["added"] or "", *step["equivalents"]]:
            named |= {each} if isinstance(each, str) else set(each)
    # A gain of the current sensor and the torque constant are one number: a corrected nameplate says the same.
    if answer["parameter_changes"]:
        named.add("current_sensor_gain")
    return answer["verdict"] != "unknown" and set(shown) <= named and not wrong_names(answer, hidden)


def test_sealed_rigs_are_answered_right_and_hardly_ever_wrong(
    verdicts: dict[int, tuple[dict[str, object], list[str]]],
) -> None:
    shown = {
        seed: (answer["verdict"], answer["effects"], hidden) for seed, (answer, hidden) in verdicts.items()
    }
    lies = [
        seed
        for seed, (answer, hidden) in verdicts.items()
        if answer["verdict"] == "named" and wrong_names(answer, hidden)
    ]
    right = [seed for seed, (answer, hidden) in verdicts.items() if is_right(answer, hidden)]
    assert len(lies) <= MOST_LIES, shown
    assert len(right) >= LEAST_RIGHT, shown
