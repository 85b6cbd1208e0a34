"""Refusals and faults of the controller in plain words: which value, which limit, what to do."""

from dataclasses import fields

from daq.errors import DeviceFaultError, DeviceRefusedError
from daq.protocol.codes import STATUS_REMEDIES, StatusCode
from daq.protocol.dictionary import Dictionary
from daq.protocol.message import Command, Reply


def check_reply(command: Command, reply: Reply, detail: str = "") -> None:
    """Raise when a reply is a refusal.

    Args:
        command: What was asked.
        reply: What came back.
        detail: Value and limit concerned, for the message.

    Raises:
        DeviceRefusedError: The status is neither OK nor CLAMPED.
    """
    if reply.status in (StatusCode.OK, StatusCode.CLAMPED):
        return
    name = _status_name(reply.status)
    remedy = STATUS_REMEDIES.get(StatusCode(reply.status)) if name else None
    words = f"{name or 'unknown to this program'}: {remedy or 'update Jointscope'}"
    raise DeviceRefusedError(
        status=reply.status,
        command=_describe(command),
        remedy=f"{words} ({detail})" if detail else words,
    )


def fault_error(faults: int, dictionary: Dictionary, tick: int | None = None) -> DeviceFaultError:
    """Return the error that names each latched fault with the controller's own text and remedy."""
    known = {fault.bit: f"{fault.name}: {fault.text} {fault.remedy}" for fault in dictionary.faults}
    bits = [bit for bit in range(16) if faults >> bit & 1]
    words = [
        known.get(bit, f"fault bit {bit}, which the controller's dictionary does not explain") for bit in bits
    ]
    where = "" if tick is None else f" at tick {tick}"
    text = "; ".join(words) or "the controller reports no fault bit; read its state again"
    return DeviceFaultError(f"drive tripped{where}: {text}", faults=faults, tick=tick)


def _status_name(status: int) -> str:
    return StatusCode(status).name if status in tuple(StatusCode) else ""


def _describe(command: Command) -> str:
    """Return the command with its short fields, as the operator may find them in the protocol's document."""
    values = ", ".join(
        f"{field.name}={value}"
        for field in fields(command)
        if isinstance(value := getattr(command, field.name), int)
    )
    return f"{type(command).__name__}({values})"
