"""The errors that acquisition can raise, in one tree.

Theory of operation. Three kinds of trouble are kept apart:

* *We were asked for something illegal* (a value out of range, a wrong type): `ValueError` or `TypeError`,
  raised where the argument enters, never from this tree.
* *The line is noisy.* Corrupt bytes are normal: the decoder counts them and goes on. `FrameError` exists so
  that the code which decodes one message can say why it gave up; the link counts it and never lets it
  travel further.
* *The rig, the port or the disk did not do what was needed.* These reach the caller, as `DaqError` or one
  of its children. Each message names the value, the limit and the remedy, because an operator reads it, not
  a programmer.

Fields that a program may want to act upon (the status code, the proposal that fits, the limit) are
attributes; the text of the message is for people only.
"""


class DaqError(Exception):
    """Anything that went wrong between the rig and the recording."""


class FrameError(DaqError):
    """The other side sent octets that are no message of this protocol; the link counts it and goes on."""


class ProtocolVersionError(DaqError):
    """Controller and host share no protocol version."""


class DictionaryError(DaqError):
    """The controller's dictionary is damaged, incomplete, or does not match the CRC that HELLO announced."""


class PortError(DaqError):
    """The serial port (or socket) does not exist, is taken by another program, or was unplugged."""


class LinkTimeoutError(DaqError, TimeoutError):
    """The controller did not answer a command after the last try."""


class DeviceFaultError(DaqError):
    """The controller tripped: its drive is off and the fault is latched.

    Args:
        message: What happened and what to do, for the operator.
        faults: Latched fault bits, see `daq.protocol.codes.FaultBit`.
        tick: Controller tick of the trip, None when unknown.
    """

    def __init__(self, message: str, *, faults: int, tick: int | None = None) -> None:
        super().__init__(message)
        self.faults = faults
        self.tick = tick


class DeviceRefusedError(DaqError):
    """The controller answered a command with a refusal.

    Args:
        status: Code of the reply, see `daq.protocol.codes.StatusCode`.
        command: Name of the refused command.
        remedy: What the operator can do about it.
    """

    def __init__(self, *, status: int, command: str, remedy: str) -> None:
        super().__init__(f"controller refused {command} with status {status}: {remedy}")
        self.status = status
        self.command = command
        self.remedy = remedy


class WireBudgetError(DaqError):
    """The stream asked for does not fit the line.

    Args:
        message: Use, limit and proposal in words.
        line_use: Share of the line that the stream would take, 1.0 = all of it.
        limit: Largest share that is accepted.
        proposal: A plan that fits, in words; empty when none does.
    """

    def __init__(self, message: str, *, line_use: float, limit: float, proposal: str = "") -> None:
        super().__init__(message)
        self.line_use = line_use
        self.limit = limit
        self.proposal = proposal


class ExcitationLimitError(DaqError):
    """An excitation would exceed a limit of the rig; it was not sent.

    Args:
        message: Quantity, value, limit and remedy in words.
        quantity: What is exceeded, for example `peak current`.
        value: Predicted value, SI.
        limit: Limit in force, same unit.
    """

    def __init__(self, message: str, *, quantity: str, value: float, limit: float) -> None:
        super().__init__(message)
        self.quantity = quantity
        self.value = value
        self.limit = limit


class RecordingError(DaqError):
    """A recording cannot be read or lacks what was asked of it (column, unit, finite numbers)."""


class JournalWriteError(RecordingError):
    """The journal could not be written (disk full, file gone); what was written stays readable."""
