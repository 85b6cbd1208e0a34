"""One emulated rig put together from a scenario: machine, program, line and port."""

import zlib
from collections.abc import Callable, Collection
from dataclasses import dataclass

import numpy as np

from daq.protocol.codes import PROTOCOL_VERSION
from daq.protocol.dictionary import build_dictionary
from mock_dsp.physics.rig import EmulatedRig
from mock_dsp.program.controller import Controller
from mock_dsp.program.dictionary import DICTIONARY
from mock_dsp.program.line_counters import LineCounters
from mock_dsp.program.state import TICK_HZ, Identity
from mock_dsp.scenario.faults import FaultName
from mock_dsp.scenario.schema import Scenario
from mock_dsp.wire.emulation import Emulation
from mock_dsp.wire.faults import FaultPlan
from mock_dsp.wire.pty import PtyPort


@dataclass(frozen=True, slots=True, kw_only=True)
class EmulationOptions:
    """How a scenario is to be run.

    Attributes:
        speed: emulated seconds per second, infinity for as fast as the host takes part.
        first_session: session of the first boot; each restart counts on.
        clock_ns: monotonic clock.
    """

    speed: float
    first_session: int
    clock_ns: Callable[[], int]


def build_emulation(scenario: Scenario, port: PtyPort, options: EmulationOptions) -> Emulation:
    """Return the emulation of a scenario, with its machine code loaded."""
    plant = EmulatedRig.from_scenario(scenario)
    plant.run(np.zeros(1))  # loads or makes the compiled code, which takes longer than a lease
    plant.reset()
    line = LineCounters()
    flash: dict[int, int] = {}
    names = {fault.name for fault in scenario.faults}

    def boot(restarts: int) -> Controller:
        identity = make_identity(options.first_session + restarts, names)
        return Controller(identity, plant, flash, line)

    return Emulation(
        boot, port, line, FaultPlan(scenario.faults, TICK_HZ), speed=options.speed, clock_ns=options.clock_ns
    )


def make_identity(session: int, faults: Collection[FaultName]) -> Identity:
    """Return what the controller tells about itself, wrong where a fault says so."""
    dictionary = build_dictionary(DICTIONARY)
    crc = zlib.crc32(dictionary)
    return Identity(
        session=session,
        dictionary=dictionary,
        dictionary_crc=crc ^ 1 if FaultName.WRONG_DICTIONARY in faults else crc,
        version=PROTOCOL_VERSION + (FaultName.NEWER_PROTOCOL in faults),
    )
