"""Sealed rigs through the whole chain: emulator, pseudo-terminal, driver, recordings, workflow; then the answer.

The seeds were written down before any of them was played, and nothing is tuned on what they show. 20261 was one
of them: its search takes longer than a test may on two cores and waits for a faster one. The campaign drives the
model by the measured current, so effects of the current port cannot show: `none` is no lie then.
"""

import json
import signal
import subprocess
import sys
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[2]
CONFIG = REPOSITORY / "config"
SEEDS = (20262, 20263)
DEADLINE_S = 400.0

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def verdicts(
    tmp_path_factory: pytest.TempPathFactory,
) -> dict[int, tuple[dict[str, object], list[str]]]:
    """Play and judge every sealed rig, and only then open the answers: gap.json and the hidden ids by seed."""
    folder = tmp_path_factory.mktemp("sealed")
    answers = {seed: play_sealed(seed, folder / str(seed)) for seed in SEEDS}
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


def test_most_verdicts_name_nothing_that_is_not_there(
    verdicts: dict[int, tuple[dict[str, object], list[str]]],
) -> None:
    wrong = {seed: wrong_names(answer, hidden) for seed, (answer, hidden) in verdicts.items()}
    confident = [seed for seed, names in wrong.items() if names and verdicts[seed][0]["verdict"] == "named"]
    shown = {
        seed: (answer["verdict"], answer["effects"], hidden) for seed, (answer, hidden) in verdicts.items()
    }
    assert len(confident) < len(SEEDS) / 2, shown
