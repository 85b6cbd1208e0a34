"""What the end-to-end tests share: emulated controllers, files of a campaign, checks of a recording."""

import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import yaml

from daq.recording.recording import Recording

CONFIG = Path(__file__).resolve().parents[2] / "config"
TICK_HZ = 2500
SINE = {"kind": "sine", "amplitude_A": 0.5, "period_s": 5, "ramp_s": 1}
Emulate = Callable[[str | Path, str], Path]
Edit = Callable[..., Path]


@pytest.fixture
def emulate(tmp_path: Path) -> Iterator[Emulate]:
    """Return a function that starts an emulated controller and returns the link to its port.

    The scenario is a file, or the name of one that the test or config/scenarios/ has.
    """
    processes: list[subprocess.Popen[str]] = []

    def start(scenario: str | Path, speed: str) -> Path:
        link = tmp_path / f"dsp{len(processes)}"
        files = (Path(scenario), tmp_path / f"{scenario}.yaml", CONFIG / "scenarios" / f"{scenario}.yaml")
        file = next(file for file in files if file.is_file())
        command = [sys.executable, "-m", "mock_dsp", "--scenario", str(file), "--link", str(link)]
        process = subprocess.Popen([*command, "--speed", speed], stdout=subprocess.PIPE, text=True)
        processes.append(process)
        assert process.stdout is not None
        assert "emulated controller on" in process.stdout.readline()
        return link

    yield start
    for process in processes:
        process.terminate()
        process.communicate(timeout=10)


@dataclass(frozen=True, slots=True, kw_only=True)
class CampaignFiles:
    """A campaign of one record step and its rig, as files that a test may change."""

    campaign: Path
    rig: Path

    def change_rig(self, section: str, **values: object) -> None:
        """Replace keys in a section of the rig file."""
        content = yaml.safe_load(self.rig.read_text())
        content[section].update(values)
        self.rig.write_text(yaml.safe_dump(content))


@pytest.fixture
def make_campaign(tmp_path: Path) -> Callable[..., CampaignFiles]:
    """Return a function that writes a campaign which plays `excitation` for `duration_s`."""

    def make(duration_s: float = 5.0, excitation: dict[str, object] | None = None) -> CampaignFiles:
        rig = yaml.safe_load((CONFIG / "rigs" / "emulated.yaml").read_text())
        rig["scenario"] = str(CONFIG / "scenarios" / "nominal.yaml")
        # A machine that runs other tests beside this one may stall the host for longer than the usual lease.
        rig["link"]["lease_ms"] = 2000
        record = {"name": "a", "duration_s": duration_s, "excitation": excitation or SINE}
        campaign = {"name": "trial", "rig": "rig.yaml", "steps": [{"record": record}]}
        files = CampaignFiles(campaign=tmp_path / "campaign.yaml", rig=tmp_path / "rig.yaml")
        files.rig.write_text(yaml.safe_dump(rig))
        files.campaign.write_text(yaml.safe_dump(campaign))
        return files

    return make


def assert_every_hole_is_told(recording: Recording) -> None:
    """Check that the gap table names every hole between the samples, with its exact length, and no other."""
    ticks = np.round(recording.time_s * TICK_HZ).astype(np.int64)
    holes = {int(row) + 1: int(step) - 1 for row, step in enumerate(np.diff(ticks)) if step != 1}
    told = {gap.row: gap.missing_samples for gap in recording.gaps if 0 < gap.row < recording.n}
    unknown = {row for row, missing in told.items() if missing == 0}  # a counter set back, a restart
    assert holes == {row: missing for row, missing in told.items() if row not in unknown}
    assert recording.metadata["samples"]["lost"] == sum(gap.missing_samples for gap in recording.gaps)
