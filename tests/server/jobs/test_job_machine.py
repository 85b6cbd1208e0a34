"""The state machine of sessions and campaigns: every transition, those that are refused included."""

import itertools
from pathlib import Path

import pytest

from server.services.errors import ConflictError
from server.services.jobs.ledger import JobLedger
from server.services.jobs.machine import ENDED, NEXT, TRANSITIONS, Happening, draw_diagram
from server.storage.database import Database, database_url, open_database
from server.storage.states import UNDER_WAY, JobState
from server.storage.tables import CampaignRow

DOCS = Path(__file__).resolve().parents[3] / "docs" / "jobs.md"


@pytest.fixture(scope="module")
def database(tmp_path_factory: pytest.TempPathFactory) -> Database:
    return open_database(database_url(tmp_path_factory.mktemp("jobs")))


@pytest.fixture
def ledger(database: Database) -> JobLedger:
    return JobLedger(database, CampaignRow, "campaign")


def put(database: Database, state: JobState) -> None:
    with database.write() as session:
        session.merge(CampaignRow(id="c1", rig_id="r", name="trial", state=state.value))


@pytest.mark.parametrize(("state", "happening", "following"), TRANSITIONS)
def test_an_allowed_transition_is_stored(
    database: Database, ledger: JobLedger, state: JobState, happening: Happening, following: JobState
) -> None:
    put(database, state)
    assert ledger.happen("c1", happening, "because") == (state, following)
    assert ledger.state("c1") is following


@pytest.mark.parametrize(
    ("state", "happening"), [pair for pair in itertools.product(JobState, Happening) if pair not in NEXT]
)
def test_every_other_transition_is_refused_and_changes_nothing(
    database: Database, ledger: JobLedger, state: JobState, happening: Happening
) -> None:
    put(database, state)
    with pytest.raises(ConflictError, match=f'"trial" is {state}: {happening} is not possible') as refused:
        ledger.happen("c1", happening)
    assert refused.value.remedy
    assert ledger.state("c1") is state


def test_no_transition_stands_twice() -> None:
    assert len(NEXT) == len(TRANSITIONS)


def test_whatever_is_under_way_can_be_cut_off_and_aborted_or_is_ending() -> None:
    for state in UNDER_WAY:
        assert NEXT[state, Happening.CUT_OFF] is JobState.INTERRUPTED
        assert (state, Happening.ABORT) in NEXT or state is JobState.ABORTING


def test_an_ended_job_moves_on_only_when_somebody_queues_it_again() -> None:
    moves = {(state, happening) for state, happening, _ in TRANSITIONS if state in ENDED}
    assert {happening for _, happening in moves} == {Happening.REQUEUE}
    assert (JobState.DONE, Happening.REQUEUE) not in moves


def test_the_diagram_in_the_docs_is_that_of_the_table() -> None:
    assert f"```mermaid\n{draw_diagram()}\n```" in DOCS.read_text(encoding="utf-8")
