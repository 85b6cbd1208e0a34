"""Whatever a host sends, the program answers and never raises."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from typing import TYPE_CHECKING, Any  # Any: strategies of different fields

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from daq.protocol.commands import Ping
from daq.protocol.framing import encode_frame
from daq.protocol.message import Command, Tail
from daq.protocol.messages import MESSAGES, encode_message
from mock_dsp.program.commands import HANDLERS

if TYPE_CHECKING:
    from tests.mock_dsp.conftest import Bench

COMMANDS = [kind for kind in MESSAGES.values() if issubclass(kind, Command)]
INTEGERS = {
    "H": st.one_of(st.integers(0, 6), st.integers(0, 0xFFFF)),
    "h": st.integers(-0x8000, 0x7FFF),
    "I": st.one_of(st.integers(0, 300), st.integers(0, 0xFFFFFFFF)),
    "i": st.one_of(st.integers(-2_000_000, 2_000_000), st.integers(-(2**31), 2**31 - 1)),
}
WORDS = st.binary(max_size=120).map(lambda octets: octets[: len(octets) // 2 * 2])


def commands_of(kind: type[Command]) -> st.SearchStrategy[Command]:
    """Return a strategy of one command class with arbitrary fields."""
    strategies: list[st.SearchStrategy[Any]] = [INTEGERS[code] for code in kind.FORMAT]
    if kind.TAIL is Tail.WORDS:
        strategies.append(WORDS)
    names = [field.name for field in fields(kind)]
    return st.builds(kind, **dict(zip(names, strategies, strict=True)))


ANY_COMMAND = st.one_of([commands_of(kind) for kind in COMMANDS])
STEPS = st.lists(st.tuples(ANY_COMMAND, st.integers(0, 700)), max_size=30)
REUSED_FIXTURE = [HealthCheck.function_scoped_fixture]


def test_every_command_has_a_handler() -> None:
    assert set(HANDLERS) == set(COMMANDS)


@settings(max_examples=150, deadline=None, suppress_health_check=REUSED_FIXTURE)
@given(steps=STEPS, trip_after=st.integers(0, 5000))
def test_no_sequence_of_commands_raises(
    make_bench: Callable[[], Bench], steps: list[tuple[Command, int]], trip_after: int
) -> None:
    bench = make_bench()
    bench.arm()
    bench.plant.trip_tick = bench.plant.tick + trip_after
    for command, ticks in steps:
        assert bench.status_of(command) in range(18)
        bench.run_ticks(ticks)


@settings(max_examples=150, deadline=None, suppress_health_check=REUSED_FIXTURE)
@given(bodies=st.lists(st.binary(min_size=2, max_size=60), max_size=30))
def test_no_frame_with_a_good_crc_raises(make_bench: Callable[[], Bench], bodies: list[bytes]) -> None:
    bench = make_bench()
    bench.greet()
    for body in bodies:
        bench.controller.receive(encode_frame(body[: len(body) // 2 * 2]))
        bench.controller.serve(100_000)
        bench.run_ticks(10)


def test_commands_wait_while_the_transmitter_has_no_room(bench: Bench) -> None:
    bench.greet()
    bench.controller.receive(encode_frame(encode_message(1, Ping(cookie=1))))
    bench.controller.serve(255)
    assert not bench.controller.take_frames()
    bench.controller.serve(256)
    assert len(bench.controller.take_frames()) == 1
