"""All rigs of the service, from their files; and the thread that looks after their leases and connections."""

import logging
import threading
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from server.config.rig import EMULATE
from server.errors import InputError, InputLocation
from server.services.errors import NotFoundError
from server.services.events import EventLog
from server.services.loading import load_rig
from server.services.rigs.lease_ledger import LeaseLedger
from server.services.rigs.served_rig import ServedRig

_LOG = logging.getLogger(__name__)
_WATCH_S = 0.1


class RigRegistry:
    """The rigs by id.

    Args:
        rigs: each with its own id.
    """

    def __init__(self, rigs: Sequence[ServedRig]) -> None:
        self._rigs = {rig.id: rig for rig in rigs}
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._watch, name="jointscope-rigs", daemon=True)

    def start(self) -> None:
        """Begin to look after leases and connections."""
        self._thread.start()

    def all(self) -> list[ServedRig]:
        """Return all rigs by name."""
        return [self._rigs[name] for name in sorted(self._rigs)]

    def get(self, rig_id: str) -> ServedRig:
        """Return one rig.

        Raises:
            NotFoundError: no such rig.
        """
        rig = self._rigs.get(rig_id)
        if rig is None:
            known = ", ".join(sorted(self._rigs)) or "none at all"
            raise NotFoundError("rig", rig_id, f"this service has {known}; rigs come from files in --rigs")
        return rig

    def close(self) -> None:
        """Bring all rigs to rest, side by side, and give their ports back."""
        self._closing.set()
        if self._thread.is_alive():
            self._thread.join()
        if self._rigs:
            with ThreadPoolExecutor(len(self._rigs)) as pool:
                list(pool.map(ServedRig.close, self._rigs.values()))

    def _watch(self) -> None:
        while not self._closing.wait(_WATCH_S):
            for rig in self._rigs.values():
                try:
                    rig.watch()
                except Exception:  # noqa: BLE001  # outermost loop: one rig must not end the watch over the others
                    _LOG.exception("rig %s could not be watched", rig.id)


def load_rigs(
    folder: Path | None,
    events: EventLog,
    ledger: LeaseLedger,
    *,
    emulate: Path | None = None,
    speed: str | None = None,
) -> list[ServedRig]:
    """Read all rig files of a folder.

    Args:
        folder: where `*.yaml` are rig files; None has none.
        events: told what happens to the rigs.
        ledger: where leases are written down.
        emulate: scenario for the rigs whose link is `emulate`.
        speed: of those rigs' emulators: `max`, or a factor of real time.

    Raises:
        InputError: no such folder, a wrong file, or two rigs of one name.
    """
    if folder is None:
        return []
    if not folder.is_dir():
        raise InputError("no such folder of rig files", InputLocation(source=folder, field="--rigs"))
    rigs: dict[str, ServedRig] = {}
    for path in sorted(folder.glob("*.yaml")):
        rig = load_rig(path)
        if rig.link.url == EMULATE:
            rig = load_rig(path, emulate=emulate, speed=speed)
        if rig.name in rigs:
            raise InputError(
                f'the rig "{rig.name}" stands in {rigs[rig.name].path} already; give it another name',
                InputLocation(source=path, field="name"),
            )
        rigs[rig.name] = ServedRig(rig, path, events, ledger)
    return list(rigs.values())
