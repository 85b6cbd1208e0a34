"""Identification sessions: one training record, perhaps a test record, live estimates, and an identification.json.

A session is a small campaign (record, record, identify) that is played as any other; what it adds is the estimators
that run while the training record is made (`server/services/live`).
"""

import uuid
from pathlib import Path

from estimators.settings import IdentifyOptions
from server.config.campaign import IdentifyStep, RecordStep
from server.config.submitted import write_document
from server.errors import InputError
from server.services.errors import ConflictError, NotFoundError
from server.services.identification import JSON_NAME, IdentifyRequest, make_options
from server.services.jobs.board import JobBoard
from server.services.jobs.books import JobAccount, SessionBook
from server.services.jobs.held_lease import check_free
from server.services.jobs.ledger import JobFilter, JobLedger, JobRow
from server.services.jobs.machine import Happening
from server.services.jobs.order import JobOrder
from server.services.jobs.planning import DOCUMENT, load_document, plan_document
from server.services.live.estimators import Audience, LiveEstimators
from server.services.live.news import SessionNews
from server.services.live.pipeline import LiveSource, choose_source
from server.services.manifest import Manifest
from server.services.plan import CampaignPlan
from server.services.rigs.calibrated import channel_columns
from server.services.rigs.registry import RigRegistry
from server.services.rigs.served_rig import ServedRig
from server.services.session_spec import (
    TEST,
    TRAIN,
    SessionSpec,
    campaign_of,
    check_records,
    check_sample_time,
    named_as_in_the_request,
)
from server.services.session_views import SessionView, session_view
from server.services.steps import StepContext, perform_step
from server.services.tokens import Principal
from server.storage.database import Database
from server.storage.states import JobState
from server.storage.tables import SessionRow

FOLDER = "sessions"


class SessionService:
    """Makes, runs and shows sessions; `news` tells of them while they run.

    Args:
        database: where they are kept.
        data_dir: below it each has a folder.
        rigs: what they run on.
        board: what runs now.
    """

    def __init__(self, database: Database, data_dir: Path, rigs: RigRegistry, board: JobBoard) -> None:
        self._database = database
        self._data_dir = data_dir
        self._rigs = rigs
        self._board = board
        self._ledger = JobLedger(database, SessionRow, "session")
        self._live: dict[str, LiveEstimators] = {}
        self.news = SessionNews()

    def create(self, spec: SessionSpec, who: Principal) -> SessionView:
        """Check a session and keep it; nothing moves.

        Raises:
            NotFoundError: no such rig.
            InputError, InvalidValueError: a value that rig or estimators do not take.
        """
        rig, job_id = self._rigs.get(spec.rig_id), uuid.uuid4().hex
        check_sample_time(spec)
        check_records(spec)
        folder = self._data_dir / FOLDER / job_id
        path = write_document(folder / DOCUMENT, campaign_of(spec, who.name))
        try:
            self._plan(path, rig)
        except BaseException:
            path.unlink()
            folder.rmdir()
            raise
        row = SessionRow(
            id=job_id,
            rig_id=rig.id,
            name=spec.name,
            state=JobState.CREATED.value,
            spec=spec.to_json(),
            folder=f"{FOLDER}/{job_id}",
            created_by=who.name,
        )
        with self._database.write() as session:
            session.add(row)
        return self.get(job_id)

    def start(self, job_id: str, who: Principal) -> SessionView:
        """Begin: the session takes the rig's lease for itself and plays.

        Raises:
            NotFoundError: no such session.
            ConflictError: it was started before, or the rig is not free.
        """
        row = self._ledger.row(job_id)
        rig = self._rigs.get(row.rig_id)
        if JobState(row.state) is JobState.CREATED:
            check_free(rig, who)
            if not self._board.is_free(rig.id):
                raise ConflictError(f"rig {rig.id} is at work", "wait for its end, or stop it")
        folder = self._data_dir / FOLDER / job_id
        plan = self._plan(folder / DOCUMENT, rig)
        live = self._make_live(job_id, plan, rig)
        book = self._book(job_id, rig, live)
        order = JobOrder(
            id=job_id,
            title=f"session {row.name}",
            rig=rig,
            who=who,
            plan=plan,
            folder=folder,
            watch=live,
            finish=_identify_what_is_there,
        )
        book.happened(Happening.START, "")
        self._live = {key: kept for key, kept in self._live.items() if self._board.find(key) is not None}
        self._live[job_id] = live
        try:
            self._board.launch(order, book)
        except BaseException as error:
            book.happened(Happening.REFUSED, str(error))
            raise
        return self.get(job_id)

    def live_of(self, rig_id: str) -> LiveEstimators | None:
        """Return the estimators that run on a rig now."""
        for job_id, live in list(self._live.items()):
            run = self._board.find(job_id)
            if run is not None and run.alive and run.order.rig.id == rig_id:
                return live
        return None

    def ask(self, job_id: str, happening: Happening) -> SessionView:
        """Pause, resume, stop or abort.

        Raises:
            NotFoundError: no such session.
            ConflictError: not possible in its present state.
        """
        row = self._ledger.row(job_id)
        self._book(job_id, self._rigs.get(row.rig_id), None).happened(happening, "")
        run = self._board.find(job_id)
        if run is not None:
            run.ask(happening)
        return self.get(job_id)

    def get(self, job_id: str) -> SessionView:
        """Return one session.

        Raises:
            NotFoundError: no such session.
        """
        return self._view(self._ledger.row(job_id))

    def page(self, wanted: JobFilter) -> list[SessionView]:
        """Return sessions, newest first."""
        return [self._view(row) for row in self._ledger.page(wanted)]

    def identification(self, job_id: str) -> Path:
        """Return the session's identification.json.

        Raises:
            NotFoundError: no such session, or it has none (yet).
        """
        row = self._ledger.row(job_id)
        path = self._data_dir / FOLDER / job_id / JSON_NAME
        if not path.is_file():
            raise NotFoundError(
                "identification", row.name, f"the session is {row.state}: {row.reason or '...'}"
            )
        return path

    def _book(self, job_id: str, rig: ServedRig, live: LiveEstimators | None) -> SessionBook:
        account = JobAccount(self._database, self._data_dir, self._ledger, rig, job_id)
        return SessionBook(account, live, self.news)

    def _make_live(self, job_id: str, plan: CampaignPlan, rig: ServedRig) -> LiveEstimators:
        """Return the estimators that learn from the training record, with the identification's own options."""
        step = plan.steps[-1].step
        if not isinstance(step, IdentifyStep):
            raise TypeError("a session ends with an identification")
        return LiveEstimators(
            TRAIN,
            step.sample_time_s,
            _options_of(step),
            lambda record: _source_of(record, rig),
            audience=Audience(
                is_there=lambda: self.news.has_followers(job_id),
                tell=lambda snapshot: self.news.publish(job_id, snapshot),
            ),
        )

    def _plan(self, path: Path, rig: ServedRig) -> CampaignPlan:
        try:
            return plan_document(load_document(path), path, rig, None)
        except InputError as error:
            raise named_as_in_the_request(error) from error

    def _view(self, row: JobRow) -> SessionView:
        if not isinstance(row, SessionRow):
            raise TypeError("a row of another kind of job")
        return session_view(row, self._board.find(row.id), self._live.get(row.id))


def _options_of(step: IdentifyStep) -> IdentifyOptions:
    return make_options(
        IdentifyRequest(
            train=Path(TRAIN),
            test=Path(TEST),
            order=step.order,
            delay=step.delay,
            methods=step.methods,
            options=step.options,
        )
    )


def _source_of(record: RecordStep, rig: ServedRig) -> LiveSource | None:
    """Return what the samples of a record are."""
    driver = rig.worker.driver
    sent = driver.dictionary.layout(record.layout).channels
    calibrations = channel_columns(driver, rig.rig)
    return choose_source(
        {each.column: each for name, each in calibrations.items() if name in sent},
        tick_hz=driver.hello.tick_hz,
        divisor=record.divisor,
        duration_s=record.duration_s,
    )


def _identify_what_is_there(context: StepContext, manifest: Manifest) -> None:
    """After a stop: identify on what was recorded; a session without a test record scores on its training record."""
    have = {name for name in (TRAIN, TEST) if context.record_path(name).is_file()}
    if TRAIN not in have:
        return
    planned, entry = context.plan.steps[-1], manifest.steps[-1]
    step = planned.step.model_copy(update={"test": TEST if TEST in have else TRAIN})
    perform_step(context, type(planned)(step=step, title=planned.title), entry)
