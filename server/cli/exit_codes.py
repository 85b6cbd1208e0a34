"""Exit codes of the command line and which error leads to which."""

from enum import IntEnum

import daq.errors as daq_errors
from server.errors import InputError, RigTrippedError, RunFailedError
from server.services.errors import InvalidValueError, NotFoundError


class ExitCode(IntEnum):
    """What the shell sees."""

    DONE = 0
    FAILED = 1
    WRONG_INPUT = 2
    RIG_REFUSED = 3
    INTERRUPTED = 130


# The first entry that the error is an instance of decides: subclasses stand before their parents.
CODES: tuple[tuple[type[BaseException], ExitCode], ...] = (
    (InputError, ExitCode.WRONG_INPUT),
    (InvalidValueError, ExitCode.WRONG_INPUT),
    (NotFoundError, ExitCode.WRONG_INPUT),
    (RigTrippedError, ExitCode.RIG_REFUSED),
    (RunFailedError, ExitCode.FAILED),
    (daq_errors.DeviceFaultError, ExitCode.RIG_REFUSED),
    (daq_errors.DeviceRefusedError, ExitCode.RIG_REFUSED),
    (daq_errors.ProtocolVersionError, ExitCode.RIG_REFUSED),
    (daq_errors.ExcitationLimitError, ExitCode.WRONG_INPUT),
    (daq_errors.WireBudgetError, ExitCode.WRONG_INPUT),
    (daq_errors.JournalWriteError, ExitCode.FAILED),
    (daq_errors.RecordingError, ExitCode.WRONG_INPUT),
    (daq_errors.DaqError, ExitCode.FAILED),
    (OSError, ExitCode.FAILED),
    (KeyboardInterrupt, ExitCode.INTERRUPTED),
)


def exit_code(error: BaseException) -> ExitCode:
    """Return the exit code of an error; one that nobody foresaw counts as a failed run."""
    return next((code for kind, code in CODES if isinstance(error, kind)), ExitCode.FAILED)
