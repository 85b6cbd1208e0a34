"""Live estimates: the same numbers however the samples come, and those of an identification of the recording."""

import itertools
from pathlib import Path

import numpy as np
import pytest

from daq.calibration.channels import ChannelCalibration
from daq.driver.outcome import RecordProgress
from daq.protocol.stream import SampleBlock
from estimators.regressors import build_regression
from estimators.settings import IdentifyOptions
from estimators.table import RecursiveSpec, find_estimator
from server.config.campaign import RecordStep
from server.services.live.estimators import Audience, LiveEstimators
from server.services.live.fits import LiveFit, RowStore
from server.services.live.hops import HopWindow, Matrix
from server.services.live.learner import Learner
from server.services.live.pipeline import LivePipeline, LiveSource, Rows

TICK_HZ, DURATION_S, SAMPLE_TIME_S = 2500, 8.0, 0.1
START = 1000
RNG = np.random.default_rng(3)
OPTIONS = IdentifyOptions(methods=("rls", "erls", "rls_kf"))


def calibration(channel: str, column: str) -> ChannelCalibration:
    return ChannelCalibration(
        channel=channel, column=column, unit="A", scale=1e-3, offset_counts=10.0, source="test"
    )


SOURCE = LiveSource(
    input=calibration("ref", "current_ref_A"),
    position=calibration("pos", "position_rad"),
    tick_hz=TICK_HZ,
    divisor=1,
    duration_s=DURATION_S,
)


def blocks(lengths: list[int], lost: tuple[int, int] = (0, 0)) -> list[SampleBlock]:
    """Cut a record of a joint into blocks of these lengths, again and again; samples `lost` never come."""
    n = int((DURATION_S + 1.0) * TICK_HZ)
    time_s = np.arange(n) / TICK_HZ
    current = np.round(600 * np.sin(2 * np.pi * time_s) + 300 * np.sin(9.0 * time_s)).astype(np.int16)
    position = np.round(2000 * np.cos(2.2 * time_s) + 500 * np.sin(7 * time_s)).astype(np.int16)
    ticks = START - 500 + np.arange(n, dtype=np.int64)
    there = (ticks < lost[0]) | (ticks >= lost[1])
    ticks, current, position = ticks[there], current[there], position[there]
    cut, made = 0, list[SampleBlock]()
    for length in itertools.cycle(lengths):
        if cut >= len(ticks):
            return made
        part = slice(cut, cut + length)
        made.append(
            SampleBlock(
                layout="control",
                divisor=1,
                ticks=ticks[part],
                counts={"ref": current[part], "pos": position[part]},
                status=np.zeros(1, np.uint16),
                gaps=(),
            )
        )
        cut += length
    return made


def learn(lengths: list[int], lost: tuple[int, int] = (0, 0)) -> dict[str, object]:
    learner = Learner(SOURCE, START, SAMPLE_TIME_S, OPTIONS)
    for block in blocks(lengths, lost):
        learner.feed(block)
    learner.finish()
    return learner.snapshot()


@pytest.mark.parametrize("lost", [(0, 0), (9000, 9100)])
@pytest.mark.parametrize("lengths", [[25], [1000, 3, 77], [100_000]])
def test_estimates_do_not_depend_on_how_the_samples_come(lengths: list[int], lost: tuple[int, int]) -> None:
    assert learn(lengths, lost) == learn([250], lost)


def test_a_hole_begins_a_segment() -> None:
    snapshot = learn([250], (9000, 9100))
    assert (snapshot["segments"], snapshot["rows"]) == (2, 80)


def test_rows_are_those_of_the_whole_signal_at_once() -> None:
    pipeline = LivePipeline(SOURCE, START, SAMPLE_TIME_S)
    whole = [rows for block in blocks([100_000]) for rows in pipeline.feed(block)] + pipeline.finish()
    assert sum(rows.u.size for rows in whole) == DURATION_S / SAMPLE_TIME_S
    assert whole[-1].time_s == pytest.approx(DURATION_S - SAMPLE_TIME_S)


def test_a_window_is_cut_where_the_grid_says() -> None:
    seen: list[tuple[int, int, int]] = []

    def work(window: Matrix, first: int, stop: int) -> Matrix:
        seen.append((len(window), first, stop))
        return window[first:stop]

    window = HopWindow(width=1, hop=4, margin=2, work=work)
    rows = np.arange(11.0)[:, None]
    given = [*window.push(rows[:3]), *window.push(rows[3:]), *window.flush()]
    assert seen == [(6, 0, 4), (8, 2, 6), (5, 2, 5)]
    assert np.array_equal(np.concatenate(given), rows)


@pytest.mark.parametrize("name", ["rls", "erls", "rls_kf"])
def test_a_finished_fit_is_the_identifications_own(name: str) -> None:
    u = RNG.standard_normal(300)
    y = np.convolve(u, [0.0, 0.5, 0.3, 0.1])[:300] + 0.01 * RNG.standard_normal(300)
    store, spec = RowStore(SAMPLE_TIME_S), find_estimator(name)
    assert isinstance(spec, RecursiveSpec)
    fit = LiveFit(name, spec, OPTIONS)
    for cut in range(0, 300, 7):
        store.append(Rows(u=u[cut : cut + 7], y=y[cut : cut + 7], begins=cut == 0, time_s=0.0))
        fit.advance(store)
    fit.finish(store)
    regression = build_regression(store.dataset(300), OPTIONS.structure)
    estimator = spec.prepare(regression, OPTIONS)
    state = estimator.init()
    estimator.run(state, regression.phi, regression.y)
    parameters = fit.to_json()["parameters"]
    assert [each["value"] for each in parameters] == state.theta.tolist()
    assert [each["std"] for each in parameters] == state.standard_errors().tolist()


def live(max_blocks: int) -> LiveEstimators:
    return LiveEstimators("train", SAMPLE_TIME_S, OPTIONS, lambda step: SOURCE, max_blocks=max_blocks)


def step() -> RecordStep:
    excitation = {"kind": "sine", "amplitude_A": 0.5, "period_s": 5}
    return RecordStep.model_validate(
        {"step": "record", "name": "train", "duration_s": DURATION_S, "excitation": excitation}
    )


def test_who_falls_behind_catches_up_from_the_journal_and_loses_nothing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    everything = blocks([250])

    class Journal:
        """Holds all blocks."""

        def __init__(self, path: Path) -> None:
            self.path = path

        def blocks(self) -> list[SampleBlock]:
            return everything

    monkeypatch.setattr("server.services.live.estimators.JournalReader", Journal)
    estimators = live(max_blocks=3)
    estimators.begin(step(), Path("train.journal"))
    estimators.take(everything)  # far more than the queue holds, in one go
    estimators.progress(
        RecordProgress(
            elapsed_s=1.0,
            duration_s=8.0,
            samples=5,
            samples_lost=0,
            link_up=True,
            trouble="",
            start_tick=START,
        )
    )
    estimators.end()
    snapshot = estimators.snapshot()
    assert snapshot is not None
    assert (snapshot["caught_up"], snapshot["complete"]) == (1, True)
    assert snapshot["estimators"] == learn([250])["estimators"]


def test_a_record_that_is_not_the_training_record_is_passed_over() -> None:
    estimators = live(max_blocks=3)
    estimators.begin(step().model_copy(update={"name": "test"}), Path("test.journal"))
    estimators.take(blocks([250]))
    estimators.end()
    assert estimators.snapshot() is None


def test_looking_ahead_changes_nothing_and_gives_what_an_end_now_would() -> None:
    looking, ending = (Learner(SOURCE, START, SAMPLE_TIME_S, OPTIONS) for _ in range(2))
    everything = blocks([250])
    for block in everything[:60]:
        looking.feed(block)
        ahead = looking.look_ahead()
        ending.feed(block)
    assert looking.snapshot() == ending.snapshot()
    assert ahead["rows"] > looking.rows
    whole = LivePipeline(SOURCE, START, SAMPLE_TIME_S)
    rows = [row for block in everything[:60] for row in whole.feed(block)] + whole.finish()
    assert (ahead["rows"], ahead["time_s"]) == (sum(each.u.size for each in rows), rows[-1].time_s)
    for block in everything[60:]:
        looking.feed(block)
    looking.finish()
    assert looking.snapshot() == learn([250])


PROGRESS = RecordProgress(
    elapsed_s=1.0, duration_s=8.0, samples=5, samples_lost=0, link_up=True, trouble="", start_tick=START
)


@pytest.mark.parametrize("anybody", [True, False])
def test_provisional_estimates_are_made_for_an_audience_only(anybody: bool) -> None:
    told: list[dict[str, object]] = []
    audience = Audience(is_there=lambda: anybody, tell=told.append)
    estimators = LiveEstimators("train", SAMPLE_TIME_S, OPTIONS, lambda step: SOURCE, audience=audience)
    estimators.begin(step(), Path("train.journal"))
    estimators.progress(PROGRESS)
    estimators.take(blocks([250])[:40])
    estimators.end()
    assert told[-1]["provisional"] is None  # the last word is final
    assert any(snapshot["provisional"] is not None for snapshot in told) == anybody
