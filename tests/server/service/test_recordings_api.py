"""Recordings over REST: upload, list, samples, download, deletion."""

import gzip
import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pyarrow as pa
import pytest
from scipy.io import savemat

from daq.exchange.importing import load_recording
from tests.server.service.conftest import Service
from tests.server.service.measured import as_csv, measured_columns, upload

PATH = "/api/v1/recordings"
ARROW = "application/vnd.apache.arrow.stream"
Json = dict[str, Any]  # JSON values


@pytest.fixture(scope="module")
def recording(service: Service) -> Json:
    return upload(service.client("run"), "shared")


def test_an_uploaded_file_becomes_a_recording(service: Service, recording: Json) -> None:
    read = service.client("read").get(f"{PATH}/{recording['id']}").json()
    assert read == recording
    assert (read["name"], read["origin"], read["created_by"]) == ("shared", "upload", "test run")
    assert (read["samples"], read["sample_time_s"]) == (3000, pytest.approx(0.01))
    assert read["columns"] == {"time_s": "s", "current_A": "A", "speed_rad_s": "rad/s"}
    assert read["details"]["source"]["file"] == "shared.csv"


def test_samples_as_json_are_the_numbers_that_were_sent(service: Service, recording: Json) -> None:
    answer = service.client("read").get(f"{PATH}/{recording['id']}/samples", params={"column": "current_A"})
    columns = answer.json()["columns"]
    assert list(columns) == ["time_s", "current_A", "gap"]
    assert columns["current_A"] == measured_columns()["current_A"].tolist()


def test_samples_as_arrow_are_the_same(service: Service, recording: Json) -> None:
    answer = service.client("read").get(f"{PATH}/{recording['id']}/samples", headers={"Accept": ARROW})
    assert answer.headers["content-type"] == ARROW
    table = pa.ipc.open_stream(answer.content).read_all()
    assert np.array_equal(table["speed_rad_s"].to_numpy(), measured_columns()["speed_rad_s"])
    assert table.schema.metadata[b"rows"] == b"3000"


def test_a_span_and_every_tenth_sample(service: Service, recording: Json) -> None:
    params = {"start_s": 1.0, "stop_s": 2.0, "every": 10}
    answer = service.client("read").get(f"{PATH}/{recording['id']}/samples", params=params).json()
    assert (answer["rows"], answer["of_rows"]) == (10, 100)
    assert answer["columns"]["time_s"] == pytest.approx(np.arange(1.0, 2.0, 0.1))


def test_minimum_and_maximum_miss_no_spike(service: Service) -> None:
    columns = measured_columns()
    columns["current_A"][1234] = 9.0
    made = upload(service.client("run"), "spike", as_csv(columns))
    drawn = service.client("read").get(f"{PATH}/{made['id']}/samples", params={"points": 20}).json()
    assert drawn["rows"] == 20
    assert max(drawn["columns"]["current_A_max"]) == 9.0
    assert min(drawn["columns"]["speed_rad_s_min"]) == columns["speed_rad_s"].min()


def test_a_hole_is_shown_at_the_sample_behind_it_however_thin_the_samples_are(service: Service) -> None:
    columns = {name: np.delete(values, slice(1003, 1100)) for name, values in measured_columns().items()}
    made = upload(service.client("run"), "hole", as_csv(columns))
    for every, row in ((1, 1003), (7, 144)):
        answer = service.client("read").get(f"{PATH}/{made['id']}/samples", params={"every": every})
        assert np.flatnonzero(answer.json()["columns"]["gap"]).tolist() == [row]


@pytest.mark.parametrize(
    ("params", "field"),
    [
        ({"column": "torque_Nm"}, "column"),
        ({"every": 2, "points": 10}, "points"),
        ({"every": 0}, "every"),
        ({"start_s": "nan"}, "start_s"),
    ],
)
def test_a_wrong_question_about_samples_names_its_field(
    service: Service, recording: Json, params: dict[str, str | int], field: str
) -> None:
    answer = service.client("read").get(f"{PATH}/{recording['id']}/samples", params=params)
    assert (answer.status_code, answer.json()["field"]) == (422, field)


@pytest.mark.parametrize("wanted", ["csv", "parquet", "mat", "hdf5", "stored"])
def test_a_download_reads_back_to_the_same_numbers(
    service: Service, recording: Json, tmp_path: Path, wanted: str
) -> None:
    answer = service.client("read").get(f"{PATH}/{recording['id']}/file", params={"format": wanted})
    name = answer.headers["content-disposition"].split('"')[1]
    path = tmp_path / name
    path.write_bytes(answer.content)
    assert np.array_equal(load_recording(path).column("current_A"), measured_columns()["current_A"])


@pytest.mark.parametrize(("wanted", "magic"), [("mdf4", b"MDF "), ("mcap", b"\x89MCAP")])
def test_a_download_for_logging_tools_is_of_their_kind(
    service: Service, recording: Json, wanted: str, magic: bytes
) -> None:
    answer = service.client("read").get(f"{PATH}/{recording['id']}/file", params={"format": wanted})
    assert answer.content.startswith(magic)


def test_nothing_is_left_of_a_download(service: Service, recording: Json) -> None:
    service.client("read").get(f"{PATH}/{recording['id']}/file", params={"format": "csv"})
    service.wait_for(lambda: not list((service.data / "tmp").iterdir()), "the end of the temporary file")


@pytest.mark.parametrize("ending", ["csv.gz", "parquet", "mat", "h5"])
def test_every_import_format_is_taken(service: Service, recording: Json, ending: str) -> None:
    formats = {"parquet": "parquet", "mat": "mat", "h5": "hdf5"}
    client = service.client("run")
    if ending == "csv.gz":
        content = gzip.compress(as_csv(measured_columns()))
    else:
        content = client.get(f"{PATH}/{recording['id']}/file", params={"format": formats[ending]}).content
    answer = client.post(PATH, params={"file": f"again.{ending}"}, content=content)
    assert answer.status_code == 201, answer.text
    assert answer.json()["samples"] == 3000


def test_columns_are_mapped_and_cut(service: Service) -> None:
    columns = measured_columns()
    columns["i[mA]"] = columns.pop("current_A") * 1000.0
    made = upload(
        service.client("run"), "mapped", as_csv(columns), map="current_A=i[mA]*0.001", start_s=1.0, stop_s=2.0
    )
    samples = service.client("read").get(f"{PATH}/{made['id']}/samples").json()
    assert samples["rows"] == 100
    assert samples["columns"]["current_A"] == pytest.approx(measured_columns()["current_A"][100:200])


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.csv", b"", "the file is empty"),
        ("a.csv", b"current_A\n1\n2\n", "has no column 'time_s'"),
        ("a.csv", b"time_s,current_A\n0,1\n1,nan\n2,3\n", "NaN"),
        ("a.parquet", b"PAR1 and nothing else", "cannot read"),
        ("a.mat", b"\x80\x04cos\nsystem\n", "a.mat"),
        ("a.h5", b"no such thing", "cannot read"),
    ],
)
def test_a_file_that_is_no_measurement_is_refused_by_its_name(
    service: Service, name: str, content: bytes, message: str
) -> None:
    answer = service.client("run").post(PATH, params={"file": name}, content=content)
    assert (answer.status_code, answer.json()["type"]) == (422, "/problems/invalid-input")
    assert message in answer.json()["detail"]
    assert str(service.data) not in answer.text


@pytest.mark.parametrize("ending", ["h5", "mat"])
def test_a_file_whose_samples_lie_elsewhere_on_this_machine_is_refused(
    service: Service, tmp_path: Path, ending: str
) -> None:
    secret, path = tmp_path / "secret", tmp_path / f"a.{ending}"
    secret.write_bytes(b"0123456789")
    with h5py.File(path, "w") as file:
        file["time_s"] = np.arange(10.0)
        file.create_dataset("x_counts", (10,), dtype="u1", external=[(str(secret), 0, 10)])
    answer = service.client("run").post(PATH, params={"file": path.name}, content=path.read_bytes())
    assert answer.status_code == 422
    assert "'x_counts' keeps its samples in another file" in answer.json()["detail"]


@pytest.mark.parametrize("name", ["a.exe", "a.pkl", "../../a", "csv", "a.csv\0"])
def test_a_file_of_another_kind_is_refused_before_it_is_sent(service: Service, name: str) -> None:
    answer = service.client("run").post(PATH, params={"file": name}, content=b"x")
    assert (answer.status_code, answer.json()["field"]) == (422, "file")


def test_a_file_name_with_folders_stays_in_the_store(service: Service) -> None:
    answer = service.client("run").post(
        PATH, params={"file": "../../../escaped.csv"}, content=as_csv(measured_columns())
    )
    assert answer.json()["name"] == "escaped"
    assert not list(service.data.parent.glob("escaped*"))


def test_a_compressed_file_that_unpacks_to_far_too_much_is_refused(
    start_service: Callable[..., Service],
) -> None:
    service = start_service("--max-upload-mib", "1")
    bomb = gzip.compress(b"0" * (9 << 20))
    answer = service.client("run").post(PATH, params={"file": "a.csv.gz"}, content=bomb)
    assert answer.status_code == 422
    assert "unpacks to more than" in answer.json()["detail"]
    large = service.client("run").post(PATH, params={"file": "a.csv"}, content=b"0" * (2 << 20))
    assert (large.status_code, large.json()["type"]) == (413, "/problems/too-large")
    pieces = service.client("run").post(
        PATH, params={"file": "a.csv"}, content=(b"0" * (1 << 16) for _ in range(32))
    )
    assert (pieces.status_code, pieces.json()["type"]) == (413, "/problems/too-large")


def test_a_file_whose_import_takes_too_much_memory_is_refused(
    start_service: Callable[..., Service], tmp_path: Path
) -> None:
    service = start_service("--max-upload-mib", "1")
    path = tmp_path / "bomb.mat"
    # Less than a megabyte that becomes 2 GB; a MAT file tells only while it is read how much is in it.
    zeros = np.zeros((1, 1 << 27), dtype=np.uint8)
    savemat(str(path), {"time_s": zeros, "x_A": zeros}, do_compression=True)
    answer = service.client("run").post(PATH, params={"file": "bomb.mat"}, content=path.read_bytes())
    assert answer.status_code == 422
    assert "memory" in answer.json()["detail"]
    assert service.client("read").get(PATH).json()["items"] == []


def test_the_list_is_filtered(service: Service) -> None:
    client = service.client("run")
    columns = measured_columns()
    columns["position_rad"] = np.cumsum(columns["speed_rad_s"]) * 0.01
    made = upload(client, "Filter 100%_me", as_csv(columns))

    def found(**params: str) -> bool:
        items = client.get(PATH, params={"limit": "500", **params}).json()["items"]
        return made["id"] in [each["id"] for each in items]

    assert found() and found(column="position_rad") and found(origin="upload")
    assert found(text="filter 100%_ME") and found(since="2020-01-01T00:00:00")
    assert not found(column="bus_voltage_V") and not found(text="100__me") and not found(rig="other")
    assert not found(until="2020-01-01T00:00:00Z") and not found(session="s") and not found(campaign="c")


def test_pages_give_every_recording_once(service: Service) -> None:
    client, ids, cursor = service.client("run"), list[str](), None
    for k in range(5):
        upload(client, f"page{k}")
    while True:
        page = client.get(PATH, params={"limit": 2} | ({"cursor": cursor} if cursor else {})).json()
        ids += [each["id"] for each in page["items"]]
        cursor = page["cursor"]
        if cursor is None:
            break
    everything = client.get(PATH, params={"limit": 500}).json()
    assert ids == [each["id"] for each in everything["items"]]
    assert len(set(ids)) == len(ids) >= 5


@pytest.mark.parametrize(
    "params",
    [
        {"cursor": "!"},
        {"cursor": "bm8="},
        {"since": "0001-01-01T00:00:00+14:00"},
        {"since": "1700000000"},
        {"until": "0.5"},
        {"until": "2026-01-31"},
        {"column": 'a"b'},
    ],
)
def test_a_wrong_filter_is_a_problem(service: Service, params: dict[str, str]) -> None:
    assert service.client("read").get(PATH, params=params).status_code == 422


def test_what_is_changed_stands_in_the_audit_log(service: Service) -> None:
    made = upload(service.client("run"), "audited")
    lines = service.client("admin").get("/api/v1/audit", params={"resource": "recordings"}).json()["items"]
    assert (lines[0]["action"], lines[0]["details"]["id"]) == ("recording.upload", made["id"])


def test_a_parquet_file_with_wrong_metadata_is_refused(service: Service) -> None:
    sink = io.BytesIO()
    table = pa.table({"time_s": [0.0, 0.1]}).replace_schema_metadata({"jointscope": '{"schema": 1}'})
    pa.parquet.write_table(table, sink)
    answer = service.client("run").post(PATH, params={"file": "a.parquet"}, content=sink.getvalue())
    assert answer.status_code == 422
