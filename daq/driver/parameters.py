"""The controller's parameters by name and in SI units."""

import zlib
from collections.abc import Callable

from daq.driver.handshake import expect
from daq.protocol.codes import LIMIT_PARAMETERS
from daq.protocol.commands import ParamGet, ParamSet
from daq.protocol.dictionary import Dictionary
from daq.protocol.message import Command, Reply
from daq.protocol.replies import ParamGetReply, ParamSetReply

Ask = Callable[[Command, str], Reply]
"""Sends a command and returns its reply; the text goes into the message of a refusal."""


class Parameters:
    """Reads and writes what the dictionary lists.

    Args:
        dictionary: Names, scales and ranges.
        ask: How to reach the controller.
    """

    def __init__(self, dictionary: Dictionary, ask: Ask) -> None:
        self._dictionary = dictionary
        self._ask = ask

    def read(self, name: str) -> float:
        """Return the value in force, SI.

        Raises:
            KeyError: No such parameter; the message lists those that exist.
        """
        parameter = self._dictionary.parameter(name)
        return parameter.to_si(self._read_raw(parameter.id))

    def read_all(self) -> dict[str, float]:
        """Return all values in force, SI, by name."""
        return {parameter.name: self.read(parameter.name) for parameter in self._dictionary.parameters}

    def write(self, name: str, value_si: float) -> float:
        """Write a value and return the one now in force, which the controller may have clamped.

        Raises:
            KeyError: No such parameter.
            ValueError: The value lies outside the range that the controller gives for it.
            DeviceRefusedError: Read-only, or locked while the drive is armed.
        """
        parameter = self._dictionary.parameter(name)
        allowed = f"[{parameter.minimum:g}, {parameter.maximum:g}] {parameter.unit}"
        if not parameter.minimum <= value_si <= parameter.maximum:
            raise ValueError(f"{name}={value_si:g} must lie in {allowed}")
        command = ParamSet(parameter=parameter.id, raw=parameter.to_raw(value_si))
        reply = expect(self._ask(command, f"{name}={value_si:g}, allowed {allowed}"), ParamSetReply)
        return parameter.to_si(reply.raw)

    def limits_crc(self) -> int:
        """Return the proof for ARM that we know the limits in force: CRC-32 of their raw values."""
        raw = [self._read_raw(int(parameter)) for parameter in LIMIT_PARAMETERS]
        return zlib.crc32(b"".join(value.to_bytes(4, "little", signed=True) for value in raw))

    def _read_raw(self, parameter: int) -> int:
        return expect(self._ask(ParamGet(parameter=parameter), ""), ParamGetReply).raw
