"""The synchronous client against the real service and the emulated controller."""

import itertools
import threading
from pathlib import Path

import numpy as np
import pytest

from daq.exchange.importing import load_recording
from jointscope_client.client import Client
from jointscope_client.emulated_service import EmulatedRig
from jointscope_client.errors import (
    AccessError,
    ClientError,
    ConflictError,
    InvalidError,
    LeaseLostError,
    NotDoneError,
    NotFoundError,
    UnreachableError,
)
from jointscope_client.records import RecordingInfo
from tests.server.service.measured import MODEL, measured_columns


def test_a_rig_is_told(emulated_rig: EmulatedRig) -> None:
    (rig,) = emulated_rig.client.rigs.all()
    assert (rig.id, rig.emulated, rig.connection, rig.drive_state) == ("emulated", True, "connected", "idle")
    assert "current_limit_A" in [each.name for each in emulated_rig.client.rigs.parameters(rig.id)]


def test_a_lease_is_renewed_while_it_is_held_and_given_back_then(emulated_rig: EmulatedRig) -> None:
    with emulated_rig.lease(ttl_s=1.0) as lease:
        threading.Event().wait(1.5)  # longer than it would live by itself
        written = lease.write_parameter("current_limit_A", 1.5)
        assert (written.value, written.unit) == (1.5, "A")
        assert emulated_rig.state().raw["lease"]["holder"] == "first admin"
    assert emulated_rig.state().raw["lease"] is None
    with pytest.raises(ClientError, match="not held"):
        lease.id  # noqa: B018  # reading it is what is tested


def test_a_lease_that_was_taken_over_says_so(emulated_rig: EmulatedRig) -> None:
    with emulated_rig.lease(ttl_s=1.0) as loser:
        with (
            emulated_rig.client.lease(emulated_rig.id, take_over=True),
            pytest.raises(LeaseLostError) as told,
        ):
            loser.write_parameter("current_limit_A", 1.0)
        for _ in range(100):
            if loser.lost:
                break
            threading.Event().wait(0.05)
        assert loser.lost
    assert told.value.type == "/problems/lease"


def test_a_problem_keeps_type_field_value_and_remedy(emulated_rig: EmulatedRig) -> None:
    with emulated_rig.lease() as lease, pytest.raises(InvalidError) as told:
        lease.write_parameter("current_limit_A", 99.0)
    problem = told.value
    assert (problem.type, problem.field, problem.value) == ("/problems/invalid-value", "value", "99.0")
    assert "give a value in" in problem.remedy
    assert problem.remedy in str(problem)


def test_what_is_wrong_has_its_own_error(emulated_rig: EmulatedRig, uploaded: RecordingInfo) -> None:
    client = emulated_rig.client
    with pytest.raises(NotFoundError):
        client.recordings.get("nobody/else?")
    with pytest.raises(AccessError), Client(emulated_rig.url, "wrong") as stranger:
        stranger.rigs.all()
    with pytest.raises(UnreachableError, match="does not answer"), Client("http://127.0.0.1:9") as nobody:
        nobody.rigs.all()
    client.recordings.delete(uploaded.id)
    with pytest.raises(ConflictError):
        client.recordings.samples(uploaded.id)


def test_address_and_token_come_from_the_environment(
    emulated_rig: EmulatedRig, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("JOINTSCOPE_URL", emulated_rig.url + "/")
    monkeypatch.setenv("JOINTSCOPE_TOKEN", emulated_rig.token)
    with Client() as client:
        assert client.rigs.get("emulated").emulated


def test_samples_come_as_numpy_with_all_digits(emulated_rig: EmulatedRig, uploaded: RecordingInfo) -> None:
    samples = emulated_rig.client.recordings.samples(uploaded.id, ["current_A"], span_s=(1.0, 2.0))
    assert (samples.rows, samples.of_rows, samples.units["current_A"]) == (100, 100, "A")
    assert np.array_equal(samples["current_A"], measured_columns()["current_A"][100:200])
    assert not samples.gap.any()
    drawn = emulated_rig.client.recordings.samples(uploaded.id, points=10)
    assert drawn["current_A_max"].max() == measured_columns()["current_A"].max()


def test_all_pages_of_a_list_are_given(emulated_rig: EmulatedRig, measured_file: Path) -> None:
    recordings = emulated_rig.client.recordings
    made = [recordings.upload(measured_file, name=f"paged {k}").id for k in range(5)]
    assert [each.id for each in recordings.all(text="paged", limit=2)] == made[::-1]
    assert recordings.delete(made[0]).deleted_at is not None
    assert recordings.undelete(made[0]).deleted_at is None


def test_a_download_is_the_recording(
    emulated_rig: EmulatedRig, uploaded: RecordingInfo, tmp_path: Path
) -> None:
    path = emulated_rig.client.recordings.download(uploaded.id, tmp_path / "a.csv", "csv")
    assert np.array_equal(load_recording(path).column("speed_rad_s"), measured_columns()["speed_rad_s"])


def test_events_are_followed(emulated_rig: EmulatedRig) -> None:
    with emulated_rig.lease():
        pass
    kinds = (event.kind for event in emulated_rig.client.events(after=0))
    assert "lease.released" in itertools.islice(kinds, 1000)


def test_models_have_versions(emulated_rig: EmulatedRig) -> None:
    models = emulated_rig.client.models
    first = models.add(MODEL, note="nameplate")
    second = models.add(models.file(first.id), parent=first.id)
    assert (second.version, second.name) == (first.version + 1, "bench")
    assert models.get(second.id).lineage == [{"kind": "model", "id": first.id}]
    assert [each.id for each in models.all(source=first.id)] == [second.id]


def test_an_analysis_that_cannot_be_done_says_why(emulated_rig: EmulatedRig, measured_file: Path) -> None:
    client = emulated_rig.client
    train, test = (client.recordings.upload(measured_file).id for _ in range(2))  # the same samples twice
    analysis = client.discrepancies.start(client.models.add(MODEL).id, [train], [test])
    with pytest.raises(NotDoneError, match="is the same recording as") as told:
        client.discrepancies.wait(analysis.id)
    assert told.value.state == "failed"
    assert client.discrepancies.get(analysis.id).state == "failed"
