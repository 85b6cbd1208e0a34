"""An identification from two recordings: the JSON file, the comparison table, the report and its plots."""

import json
import re
from collections.abc import Callable
from pathlib import Path

import pytest

from server.errors import InputError
from server.reports.comparison import TRIVIAL_TITLE, comparison_rows, describe_models
from server.reports.write import write_report
from server.services.identification import Identification, IdentifyRequest, run_identification

RecordingMaker = Callable[..., Path]


@pytest.fixture
def identification(make_recording: RecordingMaker, tmp_path: Path) -> Identification:
    """An identification of the joint of conftest."""
    request = IdentifyRequest(train=make_recording("train", seed=1), test=make_recording("test", seed=2))
    return run_identification(request, tmp_path / "out", lambda text: None)


def test_the_first_estimate_is_told_before_the_test_recording_is_read(
    make_recording: RecordingMaker, tmp_path: Path
) -> None:
    told: list[str] = []
    request = IdentifyRequest(train=make_recording("train"), test=tmp_path / "absent.parquet")
    with pytest.raises(InputError, match=r"absent.parquet: no such file"):
        run_identification(request, tmp_path / "out", told.append)
    assert told[0].startswith("first estimate, RLS: theta = [")


def test_identification_json_says_what_was_identified_from_what(identification: Identification) -> None:
    document = json.loads(identification.json_path.read_text())
    assert document["schema"] == "jointscope.identification/1"
    assert list(document["methods"]) == ["rls", "erls", "rls_kf"]
    assert document["data"]["train"]["input"] == {"column": "current_A", "unit": "A"}
    assert document["data"]["test"]["file"].endswith("test.parquet")


def test_the_table_has_every_figure_and_the_trivial_prediction(identification: Identification) -> None:
    rows = list(comparison_rows(identification.result))
    assert [row.title for row in rows] == ["RLS", "ERLS", "RLS-KF", TRIVIAL_TITLE] * 2
    assert all("-" not in row.figures.values() for row in rows if row.title != TRIVIAL_TITLE)


def test_a_batch_estimator_has_no_adapting_figures(make_recording: RecordingMaker, tmp_path: Path) -> None:
    request = IdentifyRequest(train=make_recording("a"), test=make_recording("b", seed=2), methods=("ls",))
    found = run_identification(request, tmp_path / "out", lambda text: None)
    row = next(iter(comparison_rows(found.result)))
    assert list(row.figures.values())[:2] == ["-", "-"]


def test_each_model_has_its_transfer_functions_poles_and_gain(identification: Identification) -> None:
    for _, lines in describe_models(identification.result):
        assert lines[0].startswith("G(z) = (")
        assert lines[1].startswith("G(s)")
        assert re.search(r"poles .* static gain 1\.\d+ ± ", lines[2])


@pytest.mark.slow
def test_the_report_is_one_file_that_needs_no_network(identification: Identification, tmp_path: Path) -> None:
    page = write_report(identification, tmp_path / "out").read_text(encoding="utf-8")
    assert not re.findall(r'<(?:script|link|img)[^>]+(?:src|href)="', page)
    own = re.sub(r"<script.*?</script>", "", page, flags=re.DOTALL)
    for text in (
        "Comparison",
        TRIVIAL_TITLE,
        "G(z) =",
        "RLS-KF",
        "Ljung-Box",
        "condition number",
        "free run",
    ):
        assert text in own
    assert all(
        f'id="{key}"' in page for key in ("outputs_test", "outputs_training", "parameters", "residuals")
    )


@pytest.mark.slow
def test_each_chart_is_a_png_file_too(identification: Identification, tmp_path: Path) -> None:
    write_report(identification, tmp_path / "out")
    files = sorted((tmp_path / "out").glob("*.png"))
    assert [path.stem for path in files] == ["outputs_test", "outputs_training", "parameters", "residuals"]
    assert all(path.read_bytes().startswith(b"\x89PNG") and path.stat().st_size > 10_000 for path in files)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"methods": ("rls", "lsr")}, "'lsr' is not an estimator; choose from rls, erls"),
        ({"methods": ()}, "methods is empty"),
        ({"order": 0}, "na=0 must lie in"),
        ({"delay": 0}, "delay=0 must lie in"),
        ({"sample_time_s": 30.0}, "record more, or lower the order or the delay"),
    ],
)
def test_options_that_no_estimator_takes_are_refused(
    make_recording: RecordingMaker, tmp_path: Path, change: dict[str, object], message: str
) -> None:
    path = make_recording("train", n=6000)
    request = IdentifyRequest(train=path, test=path, **change)  # type: ignore[arg-type]  # one field at a time
    with pytest.raises(InputError, match=re.escape(message)):
        run_identification(request, tmp_path / "out", lambda text: None)
