"""MDF4 (automotive measurement tools) and MCAP (Foxglove, PlotJuggler): formats with extra libraries."""

import json
from pathlib import Path
from typing import Final

from daq.errors import RecordingError
from daq.recording.recording import TIME, Recording
from daq.recording.store import GAP

MCAP_TOPIC: Final = "/recording"


def write_mdf4(recording: Recording, path: Path) -> None:
    """Write one channel group with a master channel of time.

    Raises:
        RecordingError: asammdf is not installed.
    """
    try:
        from asammdf import MDF, Signal  # an extra, and slow to import
    except ImportError as error:
        raise _missing("MDF4", "asammdf") from error

    time_s = recording.time_s
    signals = [
        Signal(samples=recording.column(name), timestamps=time_s, name=name, unit=recording.units[name])
        for name in recording.columns
        if name != TIME
    ]
    signals.append(Signal(samples=recording.gap.astype("u1"), timestamps=time_s, name=GAP))
    with MDF(version="4.10") as file:
        file.append(signals, comment=json.dumps(dict(recording.metadata)))
        file.save(path, overwrite=True, compression=2)


def write_mcap(recording: Recording, path: Path) -> None:
    """Write one JSON message per sample, in the log time of the recording's own time axis.

    That is what the viewers plot, and it is large (about 25 octets a value before compression): decimate
    first.

    Raises:
        RecordingError: mcap is not installed.
    """
    try:
        from mcap.writer import Writer  # an extra
    except ImportError as error:
        raise _missing("MCAP", "mcap") from error

    names = list(recording.columns)
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        writer.add_metadata("jointscope", {"metadata": json.dumps(dict(recording.metadata))})
        schema = writer.register_schema(
            "jointscope.Sample", "jsonschema", json.dumps(_schema(recording)).encode()
        )
        channel = writer.register_channel(MCAP_TOPIC, "json", schema)
        rows = zip(*(recording.column(name).tolist() for name in names), recording.gap.tolist(), strict=True)
        for row in rows:
            message = dict(zip([*names, GAP], row, strict=True))
            t_ns = round(message[TIME] * 1e9)
            writer.add_message(channel, t_ns, json.dumps(message).encode(), t_ns)
        writer.finish()  # type: ignore[no-untyped-call]  # mcap leaves its return type out


def _schema(recording: Recording) -> dict[str, object]:
    columns = {name: {"type": "number", "description": unit} for name, unit in recording.units.items()}
    return {"type": "object", "properties": {**columns, GAP: {"type": "boolean"}}}


def _missing(format_name: str, library: str) -> RecordingError:
    return RecordingError(
        f"{format_name} needs the library {library}; install it with: pip install 'jointscope[export]'"
    )
