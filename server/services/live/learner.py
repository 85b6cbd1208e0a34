"""Pipeline and estimators together: samples in, a snapshot of all estimates out; live data and replays alike."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from daq.calibration.channels import ChannelCalibration
from daq.protocol.stream import SampleBlock
from daq.recording.journal_reader import JournalReader
from daq.recording.store import read_recording
from estimators.settings import IdentifyOptions
from server.services.live.fits import RowStore, make_fits
from server.services.live.pipeline import LivePipeline, LiveSource, Rows, choose_source

Json = dict[str, Any]  # JSON values


class Learner:
    """All estimators of one training record.

    Args:
        source: what the samples are.
        start_tick: of the excitation's first value.
        sample_time_s: of the models.
        options: of the identification.
    """

    def __init__(
        self, source: LiveSource, start_tick: int, sample_time_s: float, options: IdentifyOptions
    ) -> None:
        self.pipeline = LivePipeline(source, start_tick, sample_time_s)
        self._store = RowStore(self.pipeline.sample_time_s)
        self._fits = make_fits(options.methods, options)
        self._time_s = 0.0

    @property
    def rows(self) -> int:
        """How many rows were used."""
        return self._store.n

    def feed(self, block: SampleBlock) -> bool:
        """Use a block; tells whether any row came of it."""
        return self._use(self.pipeline.feed(block))

    def finish(self) -> None:
        """Use what is left: the record is over."""
        self._use(self.pipeline.finish())
        for fit in self._fits.values():
            if fit is not None:
                fit.finish(self._store)

    def snapshot(self) -> Json:
        """Return all estimates as JSON values."""
        return {
            "time_s": self._time_s,
            "rows": self._store.n,
            "segments": len(self._store.starts),
            "sample_time_s": self.pipeline.sample_time_s,
            "lookahead_s": self.pipeline.lookahead_s,
            "estimators": {
                name: {"at_the_end": True} if fit is None else fit.to_json()
                for name, fit in self._fits.items()
            },
        }

    def look_ahead(self) -> Json:
        """Return the estimates as they would be if the record ended with the newest sample; nothing changes.

        They differ from the final ones (`snapshot`) by what the filters will still see: `docs/live.md` has figures.
        """
        store, time_s = self._store, self._time_s
        n = store.n
        try:
            for rows in self.pipeline.look_ahead():
                store.append(rows)
                time_s = rows.time_s
            fits = {name: fit.look_ahead(store) for name, fit in self._fits.items() if fit is not None}
            return {
                "provisional": True,
                "time_s": time_s,
                "rows": store.n,
                "newest_tick": self.pipeline.newest_tick,
                "newest_s": self.pipeline.newest_s,
                "estimators": fits,
            }
        finally:
            store.forget_after(n)

    def _use(self, pieces: list[Rows]) -> bool:
        for rows in pieces:
            self._store.append(rows)
            self._time_s = rows.time_s
        if not pieces:
            return False
        for fit in self._fits.values():
            if fit is not None:
                fit.advance(self._store)
        return True


def replay_journal(path: Path, sample_time_s: float, options: IdentifyOptions) -> Json:
    """Return the snapshot that the live estimators had at the end of a record, from its journal.

    Args:
        path: the journal, archived or not, beside its recording.
        sample_time_s: of the models.
        options: of the identification.

    Raises:
        RecordingError: the journal cannot be read.
        ValueError: its recording has no input or no position.
    """
    reader = JournalReader(path)
    metadata = read_recording(path.with_name(path.name.partition(".journal")[0] + ".parquet")).metadata
    source = choose_source(
        _by_column(metadata),
        tick_hz=metadata["tick_hz"],
        divisor=metadata["divisor"],
        duration_s=float(metadata["duration_s"]),
    )
    if source is None:
        raise ValueError(f"{path} has no input or no position")
    starts = [note["start_tick"] for note in metadata["notes"] if note["kind"] == "run"]
    learner = Learner(source, starts[-1], sample_time_s, options)
    for block in reader.blocks():
        learner.feed(block)
    learner.finish()
    return learner.snapshot()


def _by_column(metadata: Mapping[str, Any]) -> dict[str, ChannelCalibration]:  # JSON values
    calibrations = [ChannelCalibration(**each) for each in metadata["calibration"]]
    return {each.column: each for each in calibrations}
