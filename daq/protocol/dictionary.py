"""The controller's description of itself, and its way into octets and back; docs/protocol.md, "Dictionary".

On the wire it is zlib-compressed JSON; both roles build and parse it here. Conversion of counts to SI is not
here: `daq.calibration` does it, with the scales found here.
"""

import json
import math
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Final, TypeVar

from daq.errors import DictionaryError
from daq.protocol.dictionary_entries import (
    CaptureBuffer,
    Channel,
    CountType,
    FaultText,
    GeneratorName,
    Layout,
    Parameter,
    SetpointBuffer,
    WaveSlots,
)

SCHEMA: Final = "jointscope.dictionary/1"
MAX_DICTIONARY_OCTETS: Final = 65536
"""Largest dictionary on the wire, compressed."""
MAX_JSON_OCTETS: Final = 16 * MAX_DICTIONARY_OCTETS
"""Largest dictionary unpacked: no damaged or hostile one fills the memory."""

_T = TypeVar("_T")


@dataclass(frozen=True, slots=True, kw_only=True)
class Dictionary:
    """All that a host must know about one controller program."""

    device: str
    firmware: str
    parameters: tuple[Parameter, ...]
    channels: tuple[Channel, ...]
    layouts: tuple[Layout, ...]
    faults: tuple[FaultText, ...]
    generators: tuple[GeneratorName, ...]
    setpoint: SetpointBuffer = field(default_factory=SetpointBuffer)
    capture: CaptureBuffer = field(default_factory=CaptureBuffer)
    wave: WaveSlots = field(default_factory=WaveSlots)

    def parameter(self, name: str) -> Parameter:
        """The parameter called `name`; KeyError names those that exist."""
        for parameter in self.parameters:
            if parameter.name == name:
                return parameter
        raise KeyError(_unknown("parameter", name, [p.name for p in self.parameters]))

    def channel(self, name: str) -> Channel:
        """The channel called `name`; KeyError names those that exist."""
        for channel in self.channels:
            if channel.name == name:
                return channel
        raise KeyError(_unknown("channel", name, [c.name for c in self.channels]))

    def layout(self, name: str) -> Layout:
        """The layout called `name`; KeyError names those that exist."""
        for layout in self.layouts:
            if layout.name == name:
                return layout
        raise KeyError(_unknown("layout", name, [x.name for x in self.layouts]))


def build_dictionary(dictionary: Dictionary) -> bytes:
    """Return the octets that a controller serves for `dictionary`."""
    parameters = [asdict(parameter) for parameter in dictionary.parameters]
    for table in parameters:
        table["min"], table["max"] = table.pop("minimum"), table.pop("maximum")
    document = {
        "schema": SCHEMA,
        "device": dictionary.device,
        "firmware": dictionary.firmware,
        "parameters": parameters,
        "channels": [asdict(channel) | {"type": channel.type.value} for channel in dictionary.channels],
        "layouts": [asdict(layout) for layout in dictionary.layouts],
        "faults": [asdict(fault) for fault in dictionary.faults],
        "generators": [asdict(generator) for generator in dictionary.generators],
        "setpoint": asdict(dictionary.setpoint),
        "capture": asdict(dictionary.capture),
        "wave": asdict(dictionary.wave),
    }
    return zlib.compress(json.dumps(document, separators=(",", ":")).encode(), 9)


def dictionary_crc(octets: bytes) -> int:
    """CRC-32 of the compressed octets, as HELLO announces it."""
    return zlib.crc32(octets)


def parse_dictionary(octets: bytes) -> Dictionary:
    """Read the octets that a controller serves.

    Keys that this version does not know are ignored, so that a newer controller may say more.

    Raises:
        DictionaryError: Not a dictionary, or one that lacks or contradicts something; the message names it.
    """
    document = _unpack(octets)
    schema = _take(document, "schema", str, "dictionary")
    if schema != SCHEMA:
        raise DictionaryError(f"dictionary schema {schema!r} is not {SCHEMA!r}; update the older side")
    dictionary = Dictionary(
        device=_take(document, "device", str, "dictionary"),
        firmware=_take(document, "firmware", str, "dictionary"),
        parameters=_entries(document, "parameters", _parameter),
        channels=_entries(document, "channels", _channel),
        layouts=_entries(document, "layouts", _layout),
        faults=_entries(document, "faults", _fault),
        generators=_entries(document, "generators", _generator),
        setpoint=SetpointBuffer(**_sizes(document, "setpoint", ("half_words", "halves"))),
        capture=CaptureBuffer(**_sizes(document, "capture", ("words",))),
        wave=WaveSlots(**_sizes(document, "wave", ("words", "slots"))),
    )
    _check_references(dictionary)
    return dictionary


def _unknown(what: str, name: str, known: Sequence[str]) -> str:
    return f"no {what} {name!r}; the controller has {', '.join(known)}"


def _unpack(octets: bytes) -> Mapping[str, object]:
    try:
        inflater = zlib.decompressobj()
        text = inflater.decompress(octets, MAX_JSON_OCTETS)
        if not inflater.eof:
            raise DictionaryError(
                f"dictionary is cut short, or unpacks to more than {MAX_JSON_OCTETS} octets"
            )
        document = json.loads(text)
    except (zlib.error, ValueError, RecursionError) as exc:
        raise DictionaryError(
            f"dictionary of {len(octets)} octets is no zlib-compressed JSON: {exc}"
        ) from exc
    if not isinstance(document, dict):
        raise DictionaryError("dictionary is no JSON object")
    return document


def _take(table: Mapping[str, object], key: str, kind: type[_T], where: str) -> _T:
    value = table.get(key)
    if kind is float and type(value) is int:
        value = float(value)
    if not isinstance(value, kind) or (kind is int and isinstance(value, bool)):
        raise DictionaryError(f"{where}: {key}={value!r} must be of type {kind.__name__}")
    if isinstance(value, float) and not math.isfinite(value):
        raise DictionaryError(f"{where}: {key}={value!r} must be finite")
    return value


def _entries(
    document: Mapping[str, object], key: str, read: Callable[[Mapping[str, object], str], _T]
) -> tuple[_T, ...]:
    entries: list[_T] = []
    for index, table in enumerate(_take(document, key, list, "dictionary")):
        where = f"{key}[{index}]"
        if not isinstance(table, dict):
            raise DictionaryError(f"{where} must be an object")
        entries.append(read(table, where))
    return tuple(entries)


def _sizes(document: Mapping[str, object], key: str, names: tuple[str, ...]) -> dict[str, int]:
    table: dict[str, object] = _take(document, key, dict, "dictionary")
    return {name: _take(table, name, int, key) for name in names}


def _scale(table: Mapping[str, object], where: str) -> float:
    scale = _take(table, "scale", float, where)
    if scale <= 0.0:
        raise DictionaryError(f"{where}: scale={scale} must be positive")
    return scale


def _parameter(table: Mapping[str, object], where: str) -> Parameter:
    parameter = Parameter(
        id=_take(table, "id", int, where),
        name=_take(table, "name", str, where),
        unit=_take(table, "unit", str, where),
        scale=_scale(table, where),
        minimum=_take(table, "min", float, where),
        maximum=_take(table, "max", float, where),
        default=_take(table, "default", float, where),
        writable=_take(table, "writable", bool, where),
        writable_armed=_take(table, "writable_armed", bool, where),
        doc=_take(table, "doc", str, where),
    )
    if not parameter.minimum <= parameter.default <= parameter.maximum:
        raise DictionaryError(
            f"{where}: default={parameter.default} must lie in [{parameter.minimum}, {parameter.maximum}]"
        )
    return parameter


def _channel(table: Mapping[str, object], where: str) -> Channel:
    kind = _take(table, "type", str, where)
    if kind not in {count.value for count in CountType}:
        raise DictionaryError(f"{where}: type={kind!r} must be i16 or u16")
    return Channel(
        name=_take(table, "name", str, where),
        column=_take(table, "column", str, where),
        unit=_take(table, "unit", str, where),
        type=CountType(kind),
        scale=_scale(table, where),
        offset=_take(table, "offset", float, where),
    )


def _layout(table: Mapping[str, object], where: str) -> Layout:
    channels: list[object] = _take(table, "channels", list, where)
    names = tuple(name for name in channels if isinstance(name, str))
    if not names or len(names) != len(channels) or len(set(names)) != len(names):
        raise DictionaryError(f"{where}: channels={channels!r} must be different names, at least one")
    return Layout(id=_take(table, "id", int, where), name=_take(table, "name", str, where), channels=names)


def _fault(table: Mapping[str, object], where: str) -> FaultText:
    return FaultText(
        bit=_take(table, "bit", int, where),
        name=_take(table, "name", str, where),
        text=_take(table, "text", str, where),
        remedy=_take(table, "remedy", str, where),
    )


def _generator(table: Mapping[str, object], where: str) -> GeneratorName:
    return GeneratorName(id=_take(table, "id", int, where), name=_take(table, "name", str, where))


def _check_references(dictionary: Dictionary) -> None:
    """Refuse numbers or names given twice, and layouts with channels that do not exist."""
    for what, keys in (
        ("parameter ids", [parameter.id for parameter in dictionary.parameters]),
        ("parameter names", [parameter.name for parameter in dictionary.parameters]),
        ("channel names", [channel.name for channel in dictionary.channels]),
        ("layout ids", [layout.id for layout in dictionary.layouts]),
        ("layout names", [layout.name for layout in dictionary.layouts]),
    ):
        if len(set(keys)) != len(keys):
            raise DictionaryError(f"{what} are not unique: {keys}")
    known = {channel.name for channel in dictionary.channels}
    for layout in dictionary.layouts:
        if not known.issuperset(layout.channels):
            raise DictionaryError(
                f"layout {layout.name!r} has unknown channels {set(layout.channels) - known}"
            )
