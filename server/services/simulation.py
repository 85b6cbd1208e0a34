"""Simulate a joint model over a recording's input and write simulated beside measured."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from daq.errors import RecordingError
from daq.recording.recording import Recording, recording_from_columns
from server.errors import InputError, InputLocation
from server.services.discrepancy import open_for_model, read_joint_model

if TYPE_CHECKING:
    from discrepancy.simulate import SimulatedRecord

SUFFIX = "_simulated"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Simulation:
    """A simulated recording.

    Attributes:
        model_name: from the model file.
        input: column that drove it.
        units: unit of each column, simulated ones included.
        record: the arrays.
    """

    model_name: str
    input: str
    units: dict[str, str]
    record: "SimulatedRecord"


def run_simulation(model_path: Path, recording_path: Path) -> Simulation:
    """Simulate a model over a recording.

    Raises:
        InputError: the model or the recording does not allow it.
    """
    from discrepancy.errors import GapInputError
    from discrepancy.simulate import simulate_recording

    model = read_joint_model(model_path)
    recording = open_for_model(recording_path, model)
    try:
        record = simulate_recording(model, recording, str(recording_path))
    except GapInputError as error:
        raise InputError(str(error)) from error
    return Simulation(
        model_name=model.name, input=model.input, units=_units(recording, record, model.input), record=record
    )


def _units(recording: Recording, record: "SimulatedRecord", input_name: str) -> dict[str, str]:
    from daq.recording.units import unit_of

    names = (input_name, *record.simulated)
    known = {name: recording.units.get(name) or unit_of(name) or "1" for name in names}
    return known | {name + SUFFIX: known[name] for name in record.simulated}


def write_simulation(simulation: Simulation, out: Path) -> Path:
    """Write time, input, and each output simulated and measured; the ending of `out` names the format.

    Raises:
        InputError: an unknown ending, or a library that is not installed.
    """
    from daq.exchange.exporting import export_recording, format_of

    record = simulation.record
    columns = {
        "time_s": record.time_s,
        simulation.input: record.input,
        **record.measured,
        **{name + SUFFIX: values for name, values in record.simulated.items()},
    }
    try:
        export_format = format_of(out)
        units = {name: unit for name, unit in simulation.units.items() if name in columns}
        step_s = float(record.time_s[-1] / (record.time_s.size - 1))
        content = recording_from_columns(
            columns,
            sample_time_s=step_s,
            units=units,
            metadata={"simulated_with": simulation.model_name},
        )
        out.parent.mkdir(parents=True, exist_ok=True)
        return export_recording(content, out, export_format)
    except RecordingError as error:
        raise InputError(str(error), InputLocation(source=out)) from error
