"""A small fleet: joints with and without a hidden effect, as files."""

from pathlib import Path

import numpy as np

from daq.recording.recording import recording_from_columns
from daq.recording.store import write_recording
from discrepancy.simulation import slots as s
from tests.discrepancy.recorder import make_recording

MODEL = """\
name: joint
outputs: [speed_rad_s]
parameters:
  inertia: {value: 0.5, unit: kg m^2, fixed: true}
  viscous_friction: {value: 0.8, unit: N m s/rad}
  torque_constant: {value: 1.05, unit: N m/A}
"""
SAMPLES = 3000


def write_record(folder: Path, name: str, level: float, seed: int, **replaced: float) -> str:
    """Write 6 s of a joint with this much dry friction, and return the file's name; odd seeds below 10 repeat."""
    record = make_recording({s.COULOMB: level}, seed, input_seed=0 if seed < 10 else seed)
    names = ("time_s", "current_A", "speed_rad_s")
    columns = {key: np.array(record.column(key))[:SAMPLES] for key in names}
    for key, value in replaced.items():
        columns[key] = np.full(SAMPLES, value)
    path = write_recording(recording_from_columns(columns, sample_time_s=2e-3), folder / f"{name}.parquet")
    return path.name


def write_fleet(folder: Path) -> Path:
    """Write a list of two sound joints, one that stands still and one without a file; return the list."""
    (folder / "model.yaml").write_text(MODEL)
    rough = [write_record(folder, f"rough{k}", 0.12, k) for k in (1, 2, 11)]
    idle = write_record(folder, "idle", 0.0, 3, current_A=0.5)
    path = folder / "joints.csv"
    path.write_text(
        "joint,model,train,test\n"
        f"rough,model.yaml,{rough[0]};{rough[1]},{rough[2]}\n"
        f"short,model.yaml,{rough[0]},{rough[2]}\n"
        f"idle,model.yaml,{idle},{rough[2]}\n"
        f"absent,model.yaml,{rough[0]},nowhere.parquet\n"
    )
    return path
