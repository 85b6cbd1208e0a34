"""What the services raise besides the errors of `daq`; the command line turns each into an exit code.

No service prints or exits: it raises one of these, or lets an error of `daq.errors` through.
"""

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, slots=True, kw_only=True)
class InputLocation:
    """Where in the user's input something is wrong; every part is optional."""

    source: Path | str | None = None
    line: int | None = None
    field: str | None = None

    def __str__(self) -> str:
        source = "" if self.source is None else str(self.source)
        if source and self.line is not None:
            source = f"{source}:{self.line}"
        return ": ".join(part for part in (source, self.field) if part)


class InputError(ValueError):
    """The user's input is wrong; the message says which file, field and value, and what is allowed."""

    def __init__(self, message: str, location: InputLocation | None = None) -> None:
        self.location = location or InputLocation()
        where = str(self.location)
        super().__init__(f"{where}: {message}" if where else message)


class RunFailedError(RuntimeError):
    """The run did not do what it was asked for, though the input was right and the rig did not refuse."""


class RigTrippedError(RuntimeError):
    """The rig tripped or left its running state while a step was under way; names cause and remedy."""


class CampaignStoppedError(RunFailedError):
    """The operator stopped the campaign; the drive is at rest and what was recorded is whole."""
