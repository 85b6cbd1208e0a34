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
from server.services.analyses.ledger import AnalysisLedger
from server.services.attempts import FailedAttempts
from server.services.audit import AuditLog
from server.services.campaigns import CampaignService
from server.services.events import EventLog
from server.services.figures import Figures
from server.services.jobs.board import JobBoard
from server.services.models import ModelStore
from server.services.recordings.catalogue import RecordingCatalogue
from server.services.recordings.files import RecordingFiles
from server.services.retention import Retention
from server.services.rigs.lease_ledger import LeaseLedger
from server.services.rigs.registry import RigRegistry, load_rigs
from server.services.sessions import SessionService
from server.services.settings import ServiceSettings
from server.services.startup import StartReport, recover
from server.services.tickets import TicketOffice
from server.services.tokens import TokenService
from server.services.viewing.columns import LiveSources
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
    jobs: JobBoard
    sessions: SessionService
    campaigns: CampaignService
    recordings: RecordingCatalogue
    files: RecordingFiles
    models: ModelStore
    analyses: AnalysisJobs
    started: StartReport
    lock: int
    retention: Retention
    attempts: FailedAttempts
    figures: Figures = field(default_factory=Figures)
    live_sources: LiveSources = field(default_factory=LiveSources)
    tickets: TicketOffice = field(default_factory=TicketOffice)
    closing: threading.Event = field(default_factory=threading.Event)

    def end_streams(self) -> None:
        """Let every endless answer (events, live data) come to its end; called before the server waits for them."""
        self.closing.set()
        self.events.stored.close()
        self.sessions.news.close()
        for rig in self.rigs.all():
            rig.samples.close()

    def close(self) -> None:
        """Bring the rigs to rest, store what waits, and let the data folder go."""
        self.closing.set()
        self.campaigns.close()
        self.jobs.close()
        self.rigs.close()
        self.retention.close()
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
        InputError: wrong rig files or data folder, or another service uses the data folder or the database.
    """
    database = open_database_of(settings)
    lock = -1
    try:
        lock = _lock_folder(settings.data_dir)
        database.claim()
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
    registry, jobs, data_dir = RigRegistry(rigs), JobBoard(), settings.data_dir
    tokens, model_files = TokenService(database), _models_beside(settings.rigs_dir)
    recordings = RecordingCatalogue(database, data_dir, timedelta(days=settings.deletion_grace_days))
    models = ModelStore(database)
    services = Services(
        settings=settings,
        database=database,
        tokens=tokens,
        audit=AuditLog(database),
        events=events,
        rigs=registry,
        jobs=jobs,
        sessions=SessionService(database, data_dir, registry, jobs),
        campaigns=CampaignService(database, data_dir, registry, jobs, tokens, model_files),
        recordings=recordings,
        files=RecordingFiles(database, data_dir, recordings, settings.max_upload_octets),
        models=models,
        analyses=AnalysisJobs(
            AnalysisLedger(database, events),
            data_dir,
            recordings,
            models,
            settings.analysis_jobs or usable_cores(),
        ),
        started=started,
        lock=lock,
        retention=Retention(database, settings.keep_events_days, settings.keep_audit_days),
        attempts=FailedAttempts(settings.wrong_tokens_per_minute),
    )
    events.start()
    services.retention.start()
    services.rigs.start()
    services.campaigns.start()
    services.recordings.start()
    services.analyses.start()
    if settings.emulate is not None:
        for rig in services.rigs.all():
            if rig.view().emulated:
                rig.worker.start()
    return services


def _models_beside(rigs_dir: Path | None) -> Path | None:
    """Return the folder of model files that lies beside the folder of rig files."""
    folder = None if rigs_dir is None else rigs_dir.parent / "models"
    return folder if folder is not None and folder.is_dir() else None


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
