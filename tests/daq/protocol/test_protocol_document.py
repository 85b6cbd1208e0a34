"""docs/protocol.md says of octets, codes and line use what the code does."""

import dataclasses
import re
from pathlib import Path

import pytest

from daq.protocol.budget import line_use, propose_stream, wire_efficiency, wire_octets
from daq.protocol.codes import STATUS_REMEDIES, EventCode, FaultBit, LayoutId, ParameterId, StatusCode
from daq.protocol.message import Message, Tail
from daq.protocol.messages import MESSAGES

DOCUMENT = (Path(__file__).parents[3] / "docs" / "protocol.md").read_text()
_WIDTHS = {"u8": 1, "u16": 2, "i16": 2, "u32": 4, "i32": 4}
_CODES = {"B": "u8", "H": "u16", "h": "i16", "I": "u32", "i": "i32"}
_TAILS = {
    Tail.OCTETS: "u16 n, octets[n]",
    Tail.WORDS: "u16 n, words[n]",
    Tail.RATES: "u16 n, n u32",
    Tail.REST: "words to the end",
}


def rows_after(heading: str) -> list[list[str]]:
    """Cells of the first table after `heading`, without its two head lines."""
    lines = DOCUMENT[DOCUMENT.index(heading) :].splitlines()
    start = next(i for i, line in enumerate(lines) if line.startswith("|---"))
    rows = []
    for line in lines[start + 1 :]:
        if not line.startswith("|"):
            break
        rows.append([cell.strip() for cell in line.strip("|").split("|")])
    return rows


def message_rows(kind: type[Message]) -> list[list[str]]:
    at = DOCUMENT.index(f"| 0 | type | u8 | 0x{kind.TYPE:02X} |")
    lines = DOCUMENT[at:].splitlines()
    end = next((i for i, line in enumerate(lines) if not line.startswith("|")), len(lines))
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[:end]]


@pytest.mark.parametrize("kind", MESSAGES.values(), ids=lambda kind: kind.__name__)
def test_every_message_stands_octet_by_octet_in_the_document(kind: type[Message]) -> None:
    rows = message_rows(kind)
    names = [field.name for field in dataclasses.fields(kind)]
    assert [row[1] for row in rows] == ["type", "seq", *names]
    types = [_CODES[code] for code in kind.FORMAT] + ([_TAILS[kind.TAIL]] if kind.TAIL in _TAILS else [])
    assert [row[2] for row in rows] == ["u8", "u8", *types]
    at = 0
    for row in rows:
        assert int(row[0]) == at
        at += _WIDTHS.get(row[2], 0)


def test_every_status_stands_there_with_its_remedy() -> None:
    rows = rows_after("### Status of a reply")
    assert rows == [[str(s.value), s.name, STATUS_REMEDIES[s]] for s in StatusCode]


def test_every_event_and_fault_stands_there() -> None:
    events = rows_after("## 13 Events and status")
    assert [(row[0], row[1]) for row in events] == [(str(code.value), code.name) for code in EventCode]
    faults = rows_after("| fault bit | name |")
    assert [(row[0], row[1]) for row in faults] == [(str(bit.value), bit.name) for bit in FaultBit]


def test_every_parameter_and_layout_stands_there() -> None:
    ids = [number for row in rows_after("Ids 1 to 15") for number in re.findall(r"\d+", row[0])]
    names = [name for row in rows_after("Ids 1 to 15") for name in re.findall(r"`(\w+)`", row[1])]
    assert ids == [str(parameter.value) for parameter in ParameterId]
    assert [name.upper() for name in names] == [parameter.name for parameter in ParameterId]
    layouts = rows_after("Layouts that every controller has")
    assert [(row[0], row[1].strip("`").upper()) for row in layouts] == [
        (str(x.value), x.name) for x in LayoutId
    ]


_BAUDS = (115200, 230400, 460800, 937500, 2343750)


def test_the_line_use_table_is_the_codes() -> None:
    rows = rows_after("Line use at 2500 samples a second")
    assert len(rows) == 4
    for shape, octets, efficiency, *uses in rows:
        match = re.fullmatch(r"\w+ \((\d) words\), (\d+)", shape)
        assert match is not None
        channels, batch = int(match[1]), int(match[2])
        assert int(octets) == wire_octets(channels, batch)
        assert efficiency == f"{100 * wire_efficiency(channels, batch):.1f} %"
        assert uses == [f"{100 * line_use(baud, channels, batch, 1, 2500):.1f} %" for baud in _BAUDS]


def test_the_proposal_table_is_the_codes() -> None:
    channels = {"control": 3, "speed": 4, "phases": 5}
    for name, *cells in rows_after("Fastest stream within 80 %"):
        for baud, cell in zip(_BAUDS, cells, strict=True):
            proposal = propose_stream(baud, channels[name], 2500)
            assert proposal is not None
            assert cell == f"({proposal.divisor}, {proposal.batch}): {100 * proposal.line_use:.1f} %"
