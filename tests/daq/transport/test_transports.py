"""Transports against a pseudo-terminal and a socket on this machine."""

import os
import socket
import threading
import tty
from collections.abc import Iterator
from dataclasses import dataclass

import pytest

from daq.errors import PortError
from daq.transport import serial_port
from daq.transport.descriptor_reader import DescriptorReader
from daq.transport.interface import Transport
from daq.transport.opening import open_transport
from daq.transport.serial_port import SerialTransport, latency_timer_warning


@dataclass
class Pty:
    """A pseudo-terminal: `device` is the controller's end, `path` the host's."""

    device: int
    path: str


@pytest.fixture
def pty_line() -> Iterator[Pty]:
    master, slave = os.openpty()
    tty.setraw(slave)
    yield Pty(device=master, path=os.ttyname(slave))
    os.close(slave)
    os.close(master)


@pytest.fixture
def server() -> Iterator[socket.socket]:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        yield listener


def read_octets(transport: Transport, count: int) -> bytes:
    """Read until `count` octets are there."""
    data = b""
    for _ in range(200):
        data += transport.read(0.0)
        if len(data) >= count:
            break
    return data


def test_every_octet_passes_a_pty_unchanged(pty_line: Pty) -> None:
    transport = SerialTransport(pty_line.path, 115_200)
    octets = bytes(range(256))
    os.write(pty_line.device, octets)
    assert read_octets(transport, 256) == octets
    transport.write(octets)
    assert os.read(pty_line.device, 4096) == octets
    transport.close()


@pytest.mark.parametrize("baud", [937_500, 2_343_750])
def test_rates_of_the_controller_are_accepted(pty_line: Pty, baud: int) -> None:
    transport = SerialTransport(pty_line.path, 115_200)
    transport.change_baud(baud)
    os.write(pty_line.device, b"ok")
    assert read_octets(transport, 2) == b"ok"
    transport.close()


def test_taken_port_is_named(pty_line: Pty) -> None:
    owner = SerialTransport(pty_line.path, 115_200)
    with pytest.raises(PortError, match="taken by another program"):
        SerialTransport(pty_line.path, 115_200)
    owner.close()


def test_missing_port_is_named() -> None:
    with pytest.raises(PortError, match="/dev/ttyUSB99 does not exist"):
        open_transport("/dev/ttyUSB99", 115_200)


@pytest.mark.parametrize("url", ["carrier-pigeon://rig", "socket://rig", "socket://rig:port"])
def test_url_that_names_no_port_is_refused(url: str) -> None:
    with pytest.raises(PortError, match="unknown kind|is missing"):
        open_transport(url, 115_200)


def test_hung_up_pty_is_a_lost_port(pty_line: Pty) -> None:
    master, slave = os.openpty()
    tty.setraw(slave)
    transport = SerialTransport(os.ttyname(slave), 115_200)
    os.close(master)
    os.close(slave)
    with pytest.raises(PortError, match="port lost"):
        read_octets(transport, 1)
    transport.close()


def test_socket_carries_octets_and_reports_the_end(server: socket.socket) -> None:
    transport = open_transport(f"socket://127.0.0.1:{server.getsockname()[1]}", 115_200)
    peer, _ = server.accept()
    with peer:
        peer.sendall(b"\x00\x11")
        assert read_octets(transport, 2) == b"\x00\x11"
        transport.write(b"\x13")
        assert peer.recv(10) == b"\x13"
    with pytest.raises(PortError, match="closed the connection"):
        read_octets(transport, 1)
    transport.close()


def test_silent_server_is_named() -> None:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        port = listener.getsockname()[1]
    with pytest.raises(PortError, match=f"socket://127.0.0.1:{port} does not answer"):
        open_transport(f"socket://127.0.0.1:{port}", 115_200)


def test_wake_ends_a_waiting_read(pty_line: Pty, server: socket.socket) -> None:
    url = f"socket://127.0.0.1:{server.getsockname()[1]}"
    for transport in (SerialTransport(pty_line.path, 115_200, poll_s=60.0), open_transport(url, 9600)):
        reader = threading.Thread(target=transport.read, args=(0.0,))
        reader.start()
        transport.wake()
        reader.join(timeout=5.0)
        assert not reader.is_alive()
        transport.close()


@pytest.fixture
def pipe() -> Iterator[tuple[int, int]]:
    ends = os.pipe()
    yield ends
    for end in ends:
        os.close(end)


def test_octets_of_a_fast_line_are_read_at_once(pipe: tuple[int, int]) -> None:
    reader = DescriptorReader(pipe[0], 60.0, clock=lambda: 10.0)  # no time passes: octets came a moment ago
    os.write(pipe[1], b"now")
    assert reader.read(3600.0) == b"now"
    reader.close()


def test_waiting_for_the_rest_of_a_frame_ends_when_woken(pipe: tuple[int, int]) -> None:
    times = iter(range(0, 10**6, 10**4))  # each look at the clock is hours later: a slow line
    reader = DescriptorReader(pipe[0], 60.0, clock=lambda: float(next(times)))
    got: list[bytes | None] = []
    thread = threading.Thread(target=lambda: got.append(reader.read(3600.0)))
    os.write(pipe[1], b"first")
    thread.start()
    os.write(pipe[1], b" rest")
    while not got:
        reader.wake()
        thread.join(timeout=0.01)
    assert got == [b"first rest"]
    reader.close()


@pytest.mark.parametrize(("timer", "warned"), [("16", True), ("1", False), (None, False)])
def test_slow_usb_latency_timer_is_warned_about(
    tmp_path: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch, timer: str | None, warned: bool
) -> None:
    file = f"{tmp_path}/latency_timer"
    if timer is not None:
        with open(file, "w", encoding="ascii") as out:  # noqa: PTH123
            out.write(timer + "\n")
    monkeypatch.setattr(serial_port, "_LATENCY_TIMER", file)
    warning = latency_timer_warning("/dev/ttyUSB0")
    assert (warning is not None and "16 ms" in warning) == warned
