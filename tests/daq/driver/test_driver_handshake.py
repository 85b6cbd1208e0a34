"""Opening a controller: rates, version, dictionary, and the message of each refusal."""

from __future__ import annotations

import zlib
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from daq.driver.sink import SinkTap
from daq.errors import DictionaryError, PortError, ProtocolVersionError
from daq.protocol.commands import DictRead, Hello, Ping, SetBaud

if TYPE_CHECKING:
    from tests.daq.driver.conftest import Bench


def test_controller_is_brought_to_the_working_rate(bench: Bench) -> None:
    connection = bench.handshake().connect(115_200, SinkTap())
    assert connection.baud == bench.port.baud == bench.controller.baud == 937_500
    assert connection.dictionary.device == "stub"
    assert zlib.crc32(connection.dictionary_octets) == connection.hello.dictionary_crc
    assert bench.controller.count(SetBaud) == bench.controller.count(Ping) == 1


def test_controller_left_at_the_working_rate_is_found(bench: Bench) -> None:
    bench.controller.baud = 937_500
    connection = bench.handshake().connect(115_200, SinkTap())
    assert connection.baud == 937_500
    assert bench.controller.count(SetBaud) == 0


def test_line_that_does_not_carry_the_rate_stays_at_the_old_one(bench: Bench) -> None:
    bench.controller.working_bauds = (115_200,)
    connection = bench.handshake().connect(115_200, SinkTap())
    assert connection.baud == bench.port.baud == 115_200
    assert "does not carry 937500 baud" in connection.warnings[0]


def test_rate_that_the_controller_lacks_is_answered_with_those_it_has(bench: Bench) -> None:
    bench.controller.bauds = (115_200, 2_343_750)
    with pytest.raises(PortError, match="no 937500 baud; choose one of 115200, 2343750"):
        bench.handshake().connect(115_200, SinkTap())


def test_wrong_baud_is_said_with_rates_to_try(bench: Bench) -> None:
    bench.controller.baud = 460_800
    with pytest.raises(
        PortError, match=r"no controller answered at 115200 baud .* rates to try: 115200, 230400"
    ):
        bench.handshake().connect(115_200, SinkTap())


def test_garbage_at_the_wrong_baud_is_told_apart_from_silence(bench: Bench) -> None:
    bench.controller.baud = 460_800
    handshake = bench.handshake()
    with pytest.raises(PortError, match="nothing comes in: check the cable"):
        handshake.connect(115_200, SinkTap())
    noisy = bench.open_port

    def open_noisy(baud: int) -> object:
        port = noisy(baud)
        bench.port.inject(b"\x93\x11\x00\x55")
        return port

    bench.open_port = open_noisy  # type: ignore[method-assign, assignment]  # the bench stands for a noisy line
    with pytest.raises(PortError, match="octets come in but make no frames: wrong baud"):
        bench.handshake().connect(115_200, SinkTap())


def test_newer_protocol_is_refused(bench: Bench) -> None:
    bench.controller.version = 2
    with pytest.raises(ProtocolVersionError, match="this program version 1 only; update Jointscope"):
        bench.handshake().connect(115_200, SinkTap())


def test_wrong_dictionary_is_refused(bench: Bench) -> None:
    bench.controller.announced_crc = 0xDEADBEEF
    with pytest.raises(DictionaryError, match="HELLO announced .* deadbeef"):
        bench.handshake().connect(115_200, SinkTap())


def test_known_dictionary_is_not_read_again(bench: Bench, tmp_path: Path) -> None:
    bench.options = replace(bench.options, cache_dir=tmp_path / "cache")
    bench.handshake().connect(115_200, SinkTap())
    reads = bench.controller.count(DictRead)
    connection = bench.handshake().connect(937_500, SinkTap())
    assert reads > 0
    assert bench.controller.count(DictRead) == reads
    assert connection.dictionary.device == "stub"


def test_damaged_cache_is_read_again(bench: Bench, tmp_path: Path) -> None:
    bench.options = replace(bench.options, cache_dir=tmp_path)
    bench.handshake().connect(115_200, SinkTap())
    (file,) = tmp_path.iterdir()
    file.write_bytes(b"damaged")
    reads = bench.controller.count(DictRead)
    bench.handshake().connect(937_500, SinkTap())
    assert bench.controller.count(DictRead) == 2 * reads
    assert zlib.crc32(file.read_bytes()) != zlib.crc32(b"damaged")


def test_port_is_given_back_when_the_handshake_fails(bench: Bench) -> None:
    bench.controller.silent.add(Hello)
    with pytest.raises(PortError):
        bench.handshake().connect(115_200, SinkTap())
    with pytest.raises(PortError, match="cable pulled"):
        bench.port.read(0.0)
