"""The states of an analysis, and the events that tell them."""

from pathlib import Path

from server.services.analyses.ledger import AnalysisLedger
from server.services.analyses.records import AnalysisRequest
from server.services.events import EventLog
from server.storage.database import database_url, open_database
from server.storage.states import JobState


def test_an_analysis_is_told_from_its_queue_to_its_end(tmp_path: Path) -> None:
    database = open_database(database_url(tmp_path))
    events = EventLog(database)
    ledger = AnalysisLedger(database, events)
    events.start()
    made = ledger.add(AnalysisRequest(model="m", train=["a"], test=["b"]), "bench").id
    assert ledger.count(JobState.QUEUED) == 1
    assert ledger.begin(made)
    assert not ledger.begin(made)
    for fits in (1, 2):  # the second comes too soon for an event of its own
        ledger.progress(made, {"text": "searching", "fits": fits, "elapsed_s": 0.1})
    ledger.end(made, JobState.DONE, "", result={"verdict": "none"})
    ledger.end(made, JobState.FAILED, "too late")  # changes nothing
    events.close()
    told = events.page()
    assert [each.kind for each in told] == [
        "analysis.queued",
        "analysis.running",
        "analysis.progress",
        "analysis.done",
    ]
    assert {each.data["id"] for each in told} == {made}
    row = ledger.row(made)
    assert (row.state, row.progress) == ("done", {"text": "searching", "fits": 2, "elapsed_s": 0.1})
    database.close()
