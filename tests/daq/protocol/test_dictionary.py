"""The dictionary survives the way through octets; a damaged one is refused by name, never half believed."""

import json
import zlib
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from daq.errors import DictionaryError
from daq.protocol.dictionary import (
    MAX_JSON_OCTETS,
    Dictionary,
    build_dictionary,
    dictionary_crc,
    parse_dictionary,
)
from daq.protocol.dictionary_entries import (
    Channel,
    CountType,
    FaultText,
    GeneratorName,
    Layout,
    Parameter,
)

Document = dict[str, Any]  # Any: the tests damage a parsed JSON document

DICTIONARY = Dictionary(
    device="joint controller",
    firmware="1.0",
    parameters=(
        Parameter(
            id=1,
            name="current_limit_A",
            unit="A",
            scale=1e-3,
            minimum=0.0,
            maximum=2.0,
            default=2.0,
            writable=True,
            writable_armed=False,
            doc="peak current",
        ),
    ),
    channels=(
        Channel(name="current", column="current_A", unit="A", type=CountType.I16, scale=2.0**-13, offset=0.0),
    ),
    layouts=(Layout(id=1, name="control", channels=("current",)),),
    faults=(FaultText(bit=0, name="over_current", text="too much current", remedy="check the load"),),
    generators=(GeneratorName(id=1, name="sine"),),
)


def damage(change: Callable[[Document], None]) -> bytes:
    document: Document = json.loads(zlib.decompress(build_dictionary(DICTIONARY)))
    change(document)
    return zlib.compress(json.dumps(document).encode())


def test_a_dictionary_survives_the_way_through_octets() -> None:
    octets = build_dictionary(DICTIONARY)
    assert parse_dictionary(octets) == DICTIONARY
    assert dictionary_crc(octets) == zlib.crc32(octets)


def test_keys_of_a_newer_controller_are_ignored() -> None:
    def add_keys(document: Document) -> None:
        document["colour"] = "blue"
        document["parameters"][0]["since"] = 3

    assert parse_dictionary(damage(add_keys)) == DICTIONARY


def test_raw_and_si_values_of_a_parameter() -> None:
    limit = DICTIONARY.parameter("current_limit_A")
    assert limit.to_raw(1.2604) == 1260
    assert limit.to_si(1260) == pytest.approx(1.26)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda d: d.update(schema="other/1"), r"schema 'other/1' is not"),
        (lambda d: d.pop("device"), r"dictionary: device=None must be of type str"),
        (lambda d: d.update(parameters=[3]), r"parameters\[0\] must be an object"),
        (lambda d: d["parameters"][0].pop("scale"), r"parameters\[0\]: scale=None must be of type float"),
        (lambda d: d["parameters"][0].update(scale=0.0), r"parameters\[0\]: scale=0.0 must be positive"),
        (lambda d: d["parameters"][0].update(min=float("nan")), r"parameters\[0\]: min=nan must be finite"),
        (lambda d: d["parameters"][0].update(id=True), r"parameters\[0\]: id=True must be of type int"),
        (lambda d: d["parameters"][0].update(default=9.0), r"default=9.0 must lie in \[0.0, 2.0\]"),
        (lambda d: d["parameters"].append(d["parameters"][0]), r"parameter ids are not unique: \[1, 1\]"),
        (lambda d: d["channels"][0].update(type="f32"), r"channels\[0\]: type='f32' must be i16 or u16"),
        (lambda d: d["layouts"][0].update(channels=[]), r"layouts\[0\]: channels=\[\]"),
        (lambda d: d["layouts"][0].update(channels=["speed"]), r"unknown channels \{'speed'\}"),
        (lambda d: d["wave"].pop("words"), r"wave: words=None must be of type int"),
    ],
)
def test_a_wrong_entry_is_named(change: Callable[[Document], None], message: str) -> None:
    with pytest.raises(DictionaryError, match=message):
        parse_dictionary(damage(change))


@given(st.binary(max_size=200))
def test_octets_that_are_no_dictionary_are_refused(octets: bytes) -> None:
    for candidate in (octets, zlib.compress(octets)):
        with pytest.raises(DictionaryError):
            parse_dictionary(candidate)


def test_a_dictionary_cut_short_is_refused() -> None:
    with pytest.raises(DictionaryError, match="cut short"):
        parse_dictionary(build_dictionary(DICTIONARY)[:-5])


def test_a_dictionary_that_unpacks_without_end_is_refused() -> None:
    with pytest.raises(DictionaryError, match="unpacks to more than"):
        parse_dictionary(zlib.compress(b" " * (MAX_JSON_OCTETS + 1)))


@pytest.mark.parametrize("table", ["parameter", "channel", "layout"])
def test_an_unknown_name_lists_those_that_exist(table: str) -> None:
    with pytest.raises(KeyError, match="no .* 'speed'; the controller has"):
        getattr(DICTIONARY, table)("speed")
