"""All services of one process, built in order and ended in the reverse order; the API and the CLI share them.

A new service gets its collaborators by constructor, one field in `Services`, one line in `open_services`, and one in
`close` if it holds threads or files.
"""

import fcntl
import os
import threading
from dataclasses import dataclass, field
from datetime import timedelta
from pathlib import Path

from server.errors import InputError, InputLocation
from server.services.analyses.jobs import AnalysisJobs
from server.services.audit import AuditLog
from server.services.events import EventLog
from server.services.models import ModelStore
from server.services.recordings.catalogue import RecordingCatalogue
from server.services.recordings.files import RecordingFiles
from server.services.rigs.lease_ledger import LeaseLedger
from server.services.rigs.registry import RigRegistry, load_rigs
from server.services.settings import ServiceSettings
from server.services.startup import StartReport, recover
from server.services.tokens import TokenService
from server.services.workers import usable_cores
from server.storage.database import Database, database_url, open_database

LOCK_NAME = "service.lock"


@dataclass(slots=True)
class Services:
    """What routers and commands work with."""

    settings: ServiceSettings
    database: Database
    tokens: TokenService
    audit: AuditLog
    events: EventLog
    rigs: RigRegistry
    recordings: RecordingCatalogue
    files: RecordingFiles
    models: ModelStore
    analyses: AnalysisJobs
    started: StartReport
    lock: int
    closing: threading.Event = field(default_factory=threading.Event)

    def end_streams(self) -> None:
        """Let every endless answer (events, live data) come to its end; called before the server waits for them."""
        self.closing.set()
        self.events.stored.close()
        for rig in self.rigs.all():
            rig.samples.close()

    def close(self) -> None:
        """Bring the rigs to rest, store what waits, and let the data folder go."""
        self.closing.set()
        self.rigs.close()
        self.analyses.close()
        self.recordings.close()
        self.events.close()
        self.database.close()
        os.close(self.lock)


def open_database_of(settings: ServiceSettings) -> Database:
    """Open the database that the settings name, tables up to date; the data folder is made if need be."""
    try:
        settings.data_dir.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        where = InputLocation(source=settings.data_dir, field="--data")
        raise InputError(f"cannot be used as data folder: {error.strerror}", where) from error
    return open_database(settings.database_url or database_url(settings.data_dir))


def open_services(settings: ServiceSettings) -> Services:
    """Recover what a killed process left, and start everything that has a thread.

    Raises:
        InputError: wrong rig files or data folder, or another service uses the data folder.
    """
    database = open_database_of(settings)
    lock = -1
    try:
        lock = _lock_folder(settings.data_dir)
        started = recover(database, settings.data_dir)
        events = EventLog(database)
        rigs = load_rigs(
            settings.rigs_dir, events, LeaseLedger(database), emulate=settings.emulate, speed=settings.speed
        )
    except BaseException:
        database.close()
        if lock >= 0:
            os.close(lock)
        raise
    recordings = RecordingCatalogue(database, settings.data_dir, timedelta(days=settings.deletion_grace_days))
    models = ModelStore(database)
    services = Services(
        settings=settings,
        database=database,
        tokens=TokenService(database),
        audit=AuditLog(database),
        events=events,
        rigs=RigRegistry(rigs),
        recordings=recordings,
        files=RecordingFiles(database, settings.data_dir, recordings, settings.max_upload_octets),
        models=models,
        analyses=AnalysisJobs(
            database, settings.data_dir, recordings, models, settings.analysis_jobs or usable_cores()
        ),
        started=started,
        lock=lock,
    )
    events.start()
    services.rigs.start()
    services.recordings.start()
    services.analyses.start()
    if settings.emulate is not None:
        for rig in services.rigs.all():
            if rig.view().emulated:
                rig.worker.start()
    return services


def _lock_folder(folder: Path) -> int:
    descriptor = os.open(folder / LOCK_NAME, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        os.close(descriptor)
        raise InputError(
            "another service uses this data folder; end it, or give another folder",
            InputLocation(source=folder, field="--data"),
        ) from error
    return descriptor
