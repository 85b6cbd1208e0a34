"""Writes what a job does into the database, and tells it as events of its rig."""

import json
from pathlib import Path
from typing import Any

import sqlalchemy as sa
from sqlalchemy.orm import Session

from server.services.identification import JSON_NAME
from server.services.jobs.ledger import Also, JobLedger, JobRow
from server.services.jobs.machine import ENDED, Happening
from server.services.live.estimators import LiveEstimators
from server.services.live.news import SessionNews
from server.services.manifest import Ended, StepEntry
from server.services.rigs.served_rig import ServedRig
from server.services.startup import register_recording
from server.storage.database import Database
from server.storage.states import JobState
from server.storage.tables import CampaignItemRow, SessionRow
from server.storage.types import utc_now

Json = dict[str, Any]  # JSON values
ITEM_STATES = {
    Ended.RUNNING: JobState.RUNNING,
    Ended.DONE: JobState.DONE,
    Ended.FAILED: JobState.FAILED,
    Ended.REFUSED: JobState.REFUSED,
    Ended.TRIPPED: JobState.TRIPPED,
    Ended.INTERRUPTED: JobState.STOPPED,
    Ended.NOT_STARTED: JobState.QUEUED,
}


def shown_state(row: JobRow) -> JobState:
    """Return a row's state."""
    return JobState(row.state)


class JobAccount:
    """What both kinds of books share.

    Args:
        database: where recordings are listed.
        data_dir: their paths are relative to it.
        ledger: where the job's state is kept.
        rig: told as events.
        job_id: the job.
    """

    def __init__(
        self, database: Database, data_dir: Path, ledger: JobLedger, rig: ServedRig, job_id: str
    ) -> None:
        self.database = database
        self.data_dir = data_dir
        self.ledger = ledger
        self.rig = rig
        self.job_id = job_id

    def change_state(self, happening: Happening, reason: str, also: Also | None = None) -> JobState:
        """Follow the table, tell the new state and return it."""
        before, after = self.ledger.happen(self.job_id, happening, reason, also)
        name, kind = self.ledger.row(self.job_id).name, self.ledger.kind
        because = f": {reason}" if reason else ""
        self.rig.tell(
            f"{kind}.{after}",
            f'{kind} "{name}" is {after}{because}',
            id=self.job_id,
            before=before.value,
            state=after.value,
        )
        return after


class SessionBook:
    """Book of one session.

    Args:
        book: of the job.
        live: the estimators whose last word is kept.
        news: told of each new state.
    """

    def __init__(self, book: JobAccount, live: LiveEstimators | None, news: SessionNews) -> None:
        self._book = book
        self._live = live
        self._news = news

    def happened(self, happening: Happening, reason: str) -> None:
        """Take note of a change of state; at the end, of what was identified."""
        book = self._book
        if happening in (Happening.FINISHED, Happening.RESTED):
            self._note_identification()
        if book.change_state(happening, reason) in ENDED:
            self._news.end(book.job_id)
        else:
            self._news.publish(book.job_id, None)

    def step_changed(self, entry: StepEntry) -> None:
        """Keep the figures of a record."""
        if entry.figures:
            self._add_figures({"records": {entry.title: entry.figures}})
        last = None if self._live is None else self._live.snapshot()
        if last is not None and entry.kind == "record" and entry.ended is not Ended.RUNNING:
            self._add_figures({"live": last})

    def recorded(self, entry: StepEntry, path: Path) -> None:
        """List a recording; the session's own is its training record."""
        book = self._book
        recording_id = register_recording(
            book.database, book.data_dir, path, origin="session", session_id=book.job_id
        )
        if path.stem == "train":
            book.ledger.note(book.job_id, recording_id=recording_id)

    def _note_identification(self) -> None:
        path = self._book.data_dir / "sessions" / self._book.job_id / JSON_NAME
        if path.is_file():
            methods = json.loads(path.read_text(encoding="utf-8"))["methods"]
            kept = ("parameters", "scores", "warnings")
            brief = {
                name: {key: found[key] for key in kept if key in found} for name, found in methods.items()
            }
            self._add_figures({"identification": brief})

    def _add_figures(self, more: Json) -> None:
        with self._book.database.write() as session:
            row = session.get(SessionRow, self._book.job_id)
            if row is not None:
                merged = {**row.figures}
                for key, value in more.items():
                    merged[key] = {**merged.get(key, {}), **value}
                row.figures = json.loads(json.dumps(merged))


class CampaignBook:
    """Book of one campaign, kept in the job's account."""

    def __init__(self, book: JobAccount) -> None:
        self._book = book

    def happened(self, happening: Happening, reason: str) -> None:
        """Take note of a change of state; items that were not begun are cancelled with the campaign."""

        def end_items(session: Session, after: JobState) -> None:
            if after not in ENDED:
                return
            state = JobState.INTERRUPTED if after is JobState.INTERRUPTED else JobState.STOPPED
            items = sa.update(CampaignItemRow).where(CampaignItemRow.campaign_id == self._book.job_id)
            running = items.where(CampaignItemRow.state == JobState.RUNNING.value)
            session.execute(running.values(state=state.value, reason=reason, ended_at=utc_now()))
            waiting = items.where(CampaignItemRow.state == JobState.QUEUED.value)
            session.execute(waiting.values(state=JobState.CANCELLED.value, reason="not begun"))

        self._book.change_state(happening, reason, end_items)

    def step_changed(self, entry: StepEntry) -> None:
        """Keep where an item stands."""
        state = ITEM_STATES[entry.ended]
        changes: Json = {"state": state.value, "reason": entry.message, "figures": dict(entry.figures)}
        if state is JobState.RUNNING:
            changes |= {"started_at": utc_now(), "ended_at": None}
        else:
            changes["ended_at"] = utc_now()
        self._change_item(entry.index, changes)
        if state is not JobState.RUNNING:
            text = f"{entry.title}: {state}" + (f": {entry.message}" if entry.message else "")
            self._book.rig.tell(
                "campaign.step", text, id=self._book.job_id, step=entry.index, state=state.value
            )

    def recorded(self, entry: StepEntry, path: Path) -> None:
        """List a recording."""
        book = self._book
        recording_id = register_recording(
            book.database, book.data_dir, path, origin="campaign", campaign_id=book.job_id
        )
        self._change_item(entry.index, {"recording_id": recording_id})

    def _change_item(self, index: int, changes: Json) -> None:
        with self._book.database.write() as session:
            session.execute(
                sa.update(CampaignItemRow)
                .where(CampaignItemRow.campaign_id == self._book.job_id, CampaignItemRow.position == index)
                .values(**changes)
            )
