"""The emulator as a process on a real pseudo-terminal; the few things that memory cannot show."""

import select
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import serial

from daq.protocol.commands import Hello
from daq.protocol.host_link import HostLink
from daq.protocol.replies import HelloReply

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[3]
SCENARIO = ROOT / "config" / "scenarios" / "nominal.yaml"
DEADLINE_S = 60.0

Start = Callable[..., subprocess.Popen[str]]


@pytest.fixture
def start() -> Iterator[Start]:
    """Start an emulator; it is ended when the test is over."""
    processes: list[subprocess.Popen[str]] = []

    def begin(*arguments: str) -> subprocess.Popen[str]:
        command = [sys.executable, "-m", "mock_dsp", *arguments]
        process = subprocess.Popen(
            command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        processes.append(process)
        return process

    yield begin
    for process in processes:
        process.kill()
        process.communicate()


def wait_until_ready(process: subprocess.Popen[str]) -> str:
    assert process.stdout is not None
    return process.stdout.readline()


def say_hello(link: Path, baud: int = 115_200) -> HelloReply | None:
    """Open the port, ask who is there, close it again; None if nothing sensible comes within a second."""
    host = HostLink()
    end = time.monotonic() + (DEADLINE_S if baud == 115_200 else 1.0)
    with serial.Serial(str(link), baud, exclusive=True, timeout=0.05) as port:
        host.submit(Hello(proto_min=1, proto_max=1, cookie=4), time.monotonic_ns())
        while time.monotonic() < end:
            port.write(host.take_output())
            received = host.receive(port.read(max(1, port.in_waiting)), time.monotonic_ns())
            for _, reply in received.replies:
                if isinstance(reply, HelloReply):
                    return reply
            host.poll(time.monotonic_ns())
    return None


@pytest.mark.parametrize("speed", ["1", "max"])
def test_it_answers_survives_a_host_and_ends_cleanly(start: Start, tmp_path: Path, speed: str) -> None:
    link = tmp_path / "folder" / "controller"
    process = start("--scenario", str(SCENARIO), "--link", str(link), "--speed", speed)
    line = wait_until_ready(process)
    assert line == f"emulated controller on {link.readlink()} (link {link})\n"
    first, second = say_hello(link), say_hello(link)
    assert first is not None and second is not None
    assert first.session == second.session
    process.send_signal(signal.SIGTERM)
    assert process.wait(timeout=DEADLINE_S) == 0
    assert not link.is_symlink()


def test_a_host_at_the_wrong_rate_hears_nothing_sensible(start: Start, tmp_path: Path) -> None:
    link = tmp_path / "controller"
    wait_until_ready(start("--scenario", str(SCENARIO), "--link", str(link)))
    assert say_hello(link, baud=937_500) is None
    assert say_hello(link) is not None


def test_a_pulled_cable_comes_back_under_the_same_link(start: Start, tmp_path: Path) -> None:
    scenario = tmp_path / "pulled.yaml"
    scenario.write_text("name: pulled\nfaults:\n  - {name: disconnect, at_s: 0.5, duration_s: 0.5}\n")
    link = tmp_path / "controller"
    process = start("--scenario", str(scenario), "--link", str(link))
    wait_until_ready(process)
    with serial.Serial(str(link), 115_200) as port:
        select.select([port], [], [], DEADLINE_S)
        wait_until_ready(process)  # it announces itself again
    assert say_hello(link) is not None


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--scenario", "no/such.yaml"], "no/such.yaml"),
        (["--scenario", str(SCENARIO), "--speed", "0"], "'0' must be a factor"),
        (["--scenario", str(SCENARIO), "--sealed", "3"], "--sealed SEED and --answer FILE belong together"),
        ([], "give --scenario FILE"),
        (["--scenario", str(SCENARIO), "--link", str(SCENARIO)], "not a symbolic link"),
    ],
    ids=["missing file", "speed", "sealed without answer", "nothing", "link taken"],
)
def test_wrong_input_is_refused_in_words(start: Start, arguments: list[str], message: str) -> None:
    process = start(*arguments)
    _, errors = process.communicate(timeout=DEADLINE_S)
    assert process.returncode == 2
    assert message in errors
    assert "Traceback" not in errors


def test_a_sealed_run_writes_its_answer_and_says_nothing(start: Start, tmp_path: Path) -> None:
    answer = tmp_path / "answer.json"
    process = start("--sealed", "5", "--answer", str(answer), "--link", str(tmp_path / "controller"))
    assert wait_until_ready(process).startswith("emulated controller on ")
    process.terminate()
    output, errors = process.communicate(timeout=DEADLINE_S)
    assert (output, errors) == ("", "")
    assert '"effects"' in answer.read_text()
    again = start("--sealed", "5", "--answer", str(answer))
    assert again.communicate(timeout=DEADLINE_S)[1] == f"{answer} exists already; choose another path\n"
    assert again.returncode == 2
