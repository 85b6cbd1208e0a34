"""Campaigns over the API: submitted, checked, queued for their rig, played one after the other.

Theory of operation. Each rig has a queue, ordered by `position`. One thread looks after all of them: the first campaign
in line begins when its rig is free (no job, no lease of somebody else). After a restart the queues that still hold
campaigns are *held*: nobody may be there, so nothing moves until somebody releases the queue. An interrupted campaign
is never begun again but by `requeue`, and then from its first step, in a folder of its own.
"""

import logging
import shutil
import tempfile
import uuid
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from server.config.campaign import Campaign
from server.config.submitted import yaml_of_json
from server.errors import InputError, InputLocation
from server.services.campaign_views import CampaignView, Forecast, QueueView, campaign_view, read_items
from server.services.errors import ConflictError
from server.services.jobs.board import JobBoard
from server.services.jobs.books import CampaignBook, JobAccount
from server.services.jobs.ledger import JobFilter, JobLedger, JobRow
from server.services.jobs.machine import Happening
from server.services.jobs.order import JobOrder
from server.services.jobs.planning import DOCUMENT, forecast, load_document, plan_document
from server.services.jobs.queues import CampaignQueues, owner_of
from server.services.plan import CampaignPlan
from server.services.rigs.registry import RigRegistry
from server.services.rigs.served_rig import ServedRig
from server.services.tokens import Principal, TokenService
from server.storage.database import Database
from server.storage.states import JobState
from server.storage.tables import CampaignItemRow, CampaignRow

_LOG = logging.getLogger(__name__)
FOLDER = "campaigns"
_LOOK_S = 0.5
Json = dict[str, Any]  # JSON values


class CampaignService:
    """Takes, queues, runs and shows campaigns.

    Args:
        database: where they are kept.
        data_dir: below it each has a folder.
        rigs: what they run on.
        board: what runs now.
        tokens: whose owners' campaigns may begin.
        models: folder of the model files that `gap` steps may name.
    """

    def __init__(  # its collaborators
        self,
        database: Database,
        data_dir: Path,
        rigs: RigRegistry,
        board: JobBoard,
        tokens: TokenService,
        models: Path | None,
    ) -> None:
        self._database = database
        self._data_dir = data_dir
        self._rigs = rigs
        self._board = board
        self._tokens = tokens
        self._models = models
        self._ledger = JobLedger(database, CampaignRow, "campaign")
        self._queues = CampaignQueues(database, rigs, board, self._begin)

    def start(self) -> None:
        """Begin to look after the queues."""
        self._queues.start()

    def close(self) -> None:
        """Begin no further campaign."""
        self._queues.close()

    def forecast(self, text: str, rig_id: str | None, *, is_json: bool) -> Forecast:
        """Check every step and predict what it does; nothing is kept and nothing moves.

        Raises:
            InputError: something in the document is wrong.
        """
        with tempfile.TemporaryDirectory() as folder:
            plan, rig = self._read(Path(folder) / DOCUMENT, text, rig_id, is_json=is_json)
            return Forecast(
                name=plan.campaign.name,
                rig_id=rig.id,
                duration_s=plan.duration_s,
                steps=tuple(forecast(plan)),
            )

    def submit(self, text: str, rig_id: str | None, who: Principal, *, is_json: bool) -> CampaignView:
        """Check a campaign and put it at the end of its rig's queue.

        Raises:
            InputError: something in the document is wrong.
        """
        job_id = uuid.uuid4().hex
        folder = self._data_dir / FOLDER / job_id
        try:
            plan, rig = self._read(folder / DOCUMENT, text, rig_id, is_json=is_json)
        except BaseException:
            shutil.rmtree(folder, ignore_errors=True)
            raise
        with self._queues.changing:
            row = CampaignRow(
                id=job_id,
                rig_id=rig.id,
                name=plan.campaign.name,
                state=JobState.QUEUED.value,
                position=self._queues.last_position(rig.id) + 1,
                document={"owner": _describe(who), "duration_s": plan.duration_s, "attempt": 1},
                folder=f"{FOLDER}/{job_id}",
                created_by=who.name,
                items=_items(plan),
            )
            with self._database.write() as session:
                session.add(row)
        rig.tell("campaign.queued", f'campaign "{row.name}" of {who.name} is queued', id=job_id)
        self._queues.look()
        return self.get(job_id)

    def ask(self, job_id: str, happening: Happening) -> CampaignView:
        """Pause, resume, stop or abort.

        Raises:
            NotFoundError: no such campaign.
            ConflictError: not possible in its present state.
        """
        self._book(job_id).happened(happening, "")
        run = self._board.find(job_id)
        if run is not None:
            run.ask(happening)
        return self.get(job_id)

    def requeue(self, job_id: str, who: Principal) -> CampaignView:
        """Put a campaign that has ended without being done at the end of its queue; it starts from its first step.

        Raises:
            NotFoundError: no such campaign.
            ConflictError: it waits, runs, or is done.
        """
        with self._queues.changing:
            self._book(job_id).happened(Happening.REQUEUE, "")
            with self._database.write() as session:
                row = session.get_one(CampaignRow, job_id)
                row.position = self._queues.last_position(row.rig_id) + 1
                attempt = row.document.get("attempt", 1) + 1
                row.document = {**row.document, "owner": _describe(who), "attempt": attempt}
                for item in row.items:
                    item.state, item.reason, item.figures = JobState.QUEUED.value, "", {}
                    item.started_at = item.ended_at = None
        self._queues.look()
        return self.get(job_id)

    def queue(self, rig_id: str) -> QueueView:
        """Return what waits for a rig.

        Raises:
            NotFoundError: no such rig.
        """
        rig = self._rigs.get(rig_id)
        waiting = tuple(self._views(self._queues.waiting(rig.id)))
        return QueueView(rig_id=rig.id, held=self._queues.is_held(rig.id), waiting=waiting)

    def queue_length(self, rig_id: str) -> int:
        """Return how many campaigns wait for a rig."""
        return self._queues.length(rig_id)

    def arrange(self, rig_id: str, order: list[str] | None, held: bool | None) -> QueueView:
        """Put a queue into another order, hold it, or release it.

        Args:
            rig_id: the rig.
            order: ids of all waiting campaigns, first to run first; None leaves it.
            held: whether anything is begun; None leaves it.

        Raises:
            NotFoundError: no such rig.
            InvalidValueError: `order` does not name exactly those that wait.
        """
        rig = self._rigs.get(rig_id)
        with self._queues.changing:
            if order is not None:
                self._queues.reorder(rig.id, order)
            if held is not None:
                self._queues.hold(rig.id, held=held)
        self._queues.look()
        return self.queue(rig.id)

    def get(self, job_id: str) -> CampaignView:
        """Return one campaign.

        Raises:
            NotFoundError: no such campaign.
        """
        return self._views([self._ledger.row(job_id)])[0]

    def page(self, wanted: JobFilter) -> list[CampaignView]:
        """Return campaigns, newest first."""
        return self._views(self._ledger.page(wanted))

    def document(self, job_id: str) -> Path:
        """Return the campaign's document as it was submitted.

        Raises:
            NotFoundError: no such campaign.
        """
        return self._data_dir / FOLDER / self._ledger.row(job_id).id / DOCUMENT

    def _read(
        self, path: Path, text: str, rig_id: str | None, *, is_json: bool
    ) -> tuple[CampaignPlan, ServedRig]:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(yaml_of_json(text) if is_json else text, encoding="utf-8")
        campaign = load_document(path)
        rig = self._find_rig(campaign, rig_id)
        return plan_document(campaign, path, rig, self._models), rig

    def _find_rig(self, campaign: Campaign, rig_id: str | None) -> ServedRig:
        """Return the rig that the request names, or the one of the file that the campaign names."""
        if rig_id is not None:
            return self._rigs.get(rig_id)
        if campaign.rig is not None:
            for rig in self._rigs.all():
                if campaign.rig.name == rig.path.name or str(campaign.rig) == rig.id:
                    return rig
        named = (
            "names no rig" if campaign.rig is None else f"names a rig that is not here: {campaign.rig.name}"
        )
        known = ", ".join(rig.id for rig in self._rigs.all()) or "none"
        raise InputError(
            f"{named}; give the query ?rig= one of: {known}", InputLocation(source="campaign", field="rig")
        )

    def _begin(self, rig: ServedRig, row: CampaignRow) -> None:
        book = self._book(row.id)
        book.happened(Happening.TURN, "")
        if not self._tokens.is_valid(owner_of(row).token_id):
            book.happened(Happening.REFUSED, f"the token of {row.created_by} is not valid any more")
            return
        try:
            path = self.document(row.id)
            plan = plan_document(load_document(path), path, rig, self._models)
            attempt = row.document.get("attempt", 1)
            order = JobOrder(
                id=row.id,
                title=f"campaign {row.name}",
                rig=rig,
                who=owner_of(row),
                plan=plan,
                folder=path.parent / f"run-{attempt}",
            )
            self._board.launch(order, book)
        except (InputError, ConflictError) as error:
            book.happened(Happening.REFUSED, str(error))

    def _book(self, job_id: str) -> CampaignBook:
        rig = self._rigs.get(self._ledger.row(job_id).rig_id)
        return CampaignBook(JobAccount(self._database, self._data_dir, self._ledger, rig, job_id))

    def _views(self, rows: Sequence[JobRow]) -> list[CampaignView]:
        """Return campaigns as they are shown; the steps of all of them come by one query."""
        items = read_items(self._database, [row.id for row in rows])
        return [campaign_view(row, items.get(row.id, ()), self._board.find(row.id)) for row in rows]


def _items(plan: CampaignPlan) -> list[CampaignItemRow]:
    return [
        CampaignItemRow(
            position=index, kind=planned.step.step, title=planned.title, state=JobState.QUEUED.value
        )
        for index, planned in enumerate(plan.steps)
    ]


def _describe(who: Principal) -> Json:
    return {"token_id": who.token_id, "name": who.name, "scopes": sorted(who.scopes)}
