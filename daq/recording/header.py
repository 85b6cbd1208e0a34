"""The header of a journal: what is known before the first sample, enough to read the journal by itself."""

import base64
import platform
import zlib
from collections.abc import Mapping
from importlib.metadata import version
from typing import Any, Final

from daq.calibration.channels import calibrate_channels
from daq.errors import RecordingError
from daq.protocol.dictionary import Dictionary, parse_dictionary
from daq.recording.derived_speed import speed_options

SCHEMA: Final = "jointscope.journal/1"
_REQUIRED: Final = ("schema", "dictionary", "tick_hz", "divisor")


def make_header(
    *, dictionary: bytes, tick_hz: int, divisor: int, details: Mapping[str, Any] | None = None
) -> dict[str, Any]:
    """Return the header for `Journal.create`.

    Args:
        dictionary: the controller's dictionary, in the octets it served.
        tick_hz: controller ticks per second.
        divisor: ticks from one sample to the next; a STREAM_CONFIG reply in the journal overrides it.
        details: what else is known, as JSON values. docs/recordings.md lists the keys by custom: `uid`,
            `started_utc`, `operator`, `rig`, `excitation` (its seed included), `parameters`, `hello`. Two are
            acted upon: `calibration` (see `daq.calibration.channels`) and `speed` (`method`, `bandwidth_hz`).

    Raises:
        RecordingError: the calibration or the speed asked for is impossible; better now than after the run.
    """
    known = details or {}
    calibrate_channels(parse_dictionary(dictionary).channels, known.get("calibration"))
    try:
        speed_options(known.get("speed")).check(divisor / tick_hz)
    except ValueError as error:
        raise RecordingError(str(error)) from error
    return {
        **known,
        "schema": SCHEMA,
        "dictionary": base64.b64encode(dictionary).decode(),
        "tick_hz": tick_hz,
        "divisor": divisor,
        "software": software_versions(),
    }


def check_header(header: Mapping[str, Any]) -> None:
    """Refuse a header that this version cannot read a journal with.

    Raises:
        RecordingError: naming what is missing or of another version.
    """
    missing = [key for key in _REQUIRED if key not in header]
    if missing:
        raise RecordingError(f"the journal's header lacks {', '.join(missing)}")
    if header["schema"] != SCHEMA:
        raise RecordingError(
            f"the journal has the schema {header['schema']!r}; this version reads {SCHEMA!r}"
        )


def dictionary_octets(header: Mapping[str, Any]) -> bytes:
    """Return the controller's dictionary in the octets it served."""
    return base64.b64decode(header["dictionary"])


def dictionary_of(header: Mapping[str, Any]) -> Dictionary:
    """Return the controller's dictionary."""
    return parse_dictionary(dictionary_octets(header))


def dictionary_json(header: Mapping[str, Any]) -> str:
    """Return the controller's dictionary as the JSON text it consists of."""
    return zlib.decompress(dictionary_octets(header)).decode()


def software_versions() -> dict[str, str]:
    """Return the versions of what records."""
    libraries = {name: version(name) for name in ("jointscope", "numpy", "pyarrow")}
    return {"python": platform.python_version(), **libraries}
