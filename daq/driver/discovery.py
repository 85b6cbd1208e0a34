"""Which ports this computer has: what `jointscope devices` lists, and what a wrong port name is answered with."""

from dataclasses import dataclass
from pathlib import Path

from serial.tools import list_ports

from daq.transport.serial_port import latency_timer_warning

_SYSTEM_DEVICES = Path("/dev")


@dataclass(frozen=True, slots=True, kw_only=True)
class DeviceInfo:
    """One port that could lead to a controller.

    Attributes:
        url: What to give to `open_rig`.
        description: Name of the adapter, or where a link leads.
        serial_number: Serial number of the USB adapter, empty when there is none.
        warning: What will slow this port down, empty when nothing does.
    """

    url: str
    description: str
    serial_number: str = ""
    warning: str = ""


def list_devices(link_folders: tuple[Path, ...] = ()) -> list[DeviceInfo]:
    """Return the serial ports of this computer, and the links to pseudo-terminals in `link_folders`.

    Args:
        link_folders: Folders where emulated controllers leave links to their pseudo-terminals.
    """
    found = [
        DeviceInfo(
            url=port.device,
            description=port.description if port.description != "n/a" else "serial port",
            serial_number=port.serial_number or "",
            warning=latency_timer_warning(port.device) or "",
        )
        for port in sorted(list_ports.comports(), key=lambda port: port.device)
    ]
    for folder in link_folders:
        found.extend(_emulated_in(folder))
    return found


def describe_devices(devices: list[DeviceInfo]) -> str:
    """Return one line that names the ports found, for the end of an error message."""
    if not devices:
        return "no serial port was found on this computer; check the cable and the adapter's driver"
    return "ports found: " + ", ".join(f"{device.url} ({device.description})" for device in devices)


def _emulated_in(folder: Path) -> list[DeviceInfo]:
    if not folder.is_dir():
        return []
    links = sorted(path for path in folder.iterdir() if path.is_symlink())
    return [
        DeviceInfo(url=str(link), description=f"pseudo-terminal {link.resolve()}")
        for link in links
        if link.exists() and link.resolve().is_relative_to(_SYSTEM_DEVICES / "pts")
    ]
