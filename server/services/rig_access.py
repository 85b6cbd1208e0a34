"""Open the controller that a rig file names: a real port, or an emulated one started for the purpose."""

import contextlib
import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from daq.driver.options import RigOptions
from daq.driver.rig import Rig as DriverRig
from daq.driver.rig import open_rig
from daq.errors import PortError
from daq.protocol.reports import Event
from daq.protocol.round_trip import LinkOptions
from server.config.rig import EMULATE, Rig
from server.errors import InputError, InputLocation
from server.services.emulator import emulated_controller

# A controller answers within milliseconds; an emulated one waits for its turn on a busy machine like any process.
EMULATED_LINK = LinkOptions(rto_min_ns=150_000_000)


@dataclass(frozen=True, slots=True, kw_only=True)
class RigHooks:
    """What the driver asks and tells while a rig is open.

    Attributes:
        may_keep_alive: asked before each keep-alive; a no lets the drive stop by itself.
        on_event: told of every event of the controller; must not wait.
    """

    may_keep_alive: Callable[[], bool] | None = None
    on_event: Callable[[Event], None] | None = None


@contextlib.contextmanager
def connected_rig(
    rig: Rig, rig_path: Path, tell: Callable[[str], None], hooks: RigHooks | None = None
) -> Iterator[DriverRig]:
    """Open the rig, write the parameters of its file, and close it afterwards.

    Args:
        rig: its file's content.
        rig_path: the file, for messages.
        tell: takes lines for the user.
        hooks: what the driver asks and tells while the rig is open.

    Raises:
        InputError: no such port, taken, nobody there, or a parameter that the controller does not have.
        ProtocolVersionError: the controller speaks another protocol.
    """
    with contextlib.ExitStack() as stack:
        url = rig.link.url
        if url == EMULATE:
            url = _emulate(rig, stack)
            tell(f"emulated controller on {url}")
        driver = stack.enter_context(_open(url, rig, rig_path, hooks or RigHooks()))
        for warning in driver.warnings:
            tell(f"warning: {warning}")
        for name, value in rig.parameters.items():
            _write_parameter(driver, name, value, rig_path)
        yield driver


def measured_calibration(driver: DriverRig, rig: Rig) -> Mapping[str, Mapping[str, object]]:
    """Return the rig file's calibration by channel, as the journal's header takes it.

    Raises:
        InputError: a column that this controller does not have.
    """
    channels = {channel.column: channel.name for channel in driver.dictionary.channels}
    found: dict[str, Mapping[str, object]] = {}
    for column, numbers in rig.calibration.items():
        if column not in channels:
            raise InputError(
                f"calibration: this controller has no column {column}; it has {', '.join(channels)}"
            )
        found[channels[column]] = {**numbers.model_dump(exclude_none=True), "source": f"rig file {rig.name}"}
    return found


def cache_folder() -> Path:
    """Return where dictionaries of known controllers are kept."""
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "jointscope" / "dictionaries"


def _emulate(rig: Rig, stack: contextlib.ExitStack) -> str:
    if rig.scenario is None:
        raise InputError('link.url "emulate" needs a scenario; give --emulate SCENARIO')
    return stack.enter_context(emulated_controller(rig.scenario, str(rig.emulation_speed)))


def _open(url: str, rig: Rig, rig_path: Path, hooks: RigHooks) -> DriverRig:
    options = RigOptions(
        baud=int(rig.link.baud),
        cache_dir=cache_folder(),
        link=EMULATED_LINK if rig.link.url == EMULATE else LinkOptions(),
        may_keep_alive=hooks.may_keep_alive,
        on_event=hooks.on_event,
    )
    try:
        return open_rig(url, options)
    except PortError as error:
        raise InputError(str(error), InputLocation(source=rig_path, field="link.url")) from error


def _write_parameter(driver: DriverRig, name: str, value: float, rig_path: Path) -> None:
    try:
        driver.write_parameter(name, value)
    except (KeyError, ValueError) as error:
        where = InputLocation(source=rig_path, field=f"parameters.{name}")
        raise InputError(_text(error), where) from error


def _text(error: Exception) -> str:
    """Return the message; a KeyError's own text puts it in quotes."""
    return str(error.args[0]) if isinstance(error, KeyError) else str(error)
