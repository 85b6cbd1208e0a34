"""The live estimators of a session: a thread with a bounded queue of its own, which catches up from the journal.

Theory of operation. The rig's data task hands blocks to `take`, which never waits: when the queue is full it only notes
that the thread is behind. The thread then uses what the queue holds, and reads the rest from the journal, where every
octet was before any block was: nothing is lost, and the estimates are those of all samples. The queue is shared with
nobody; a page that hangs costs the estimators nothing, nor they the recorder.
"""

import logging
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from daq.driver.outcome import RecordProgress
from daq.protocol.stream import SampleBlock
from daq.recording.journal_reader import ARCHIVE_SUFFIX, JournalReader
from estimators.settings import IdentifyOptions
from server.config.campaign import RecordStep
from server.services.live.learner import Learner
from server.services.live.pipeline import LiveSource

_LOG = logging.getLogger(__name__)
MAX_BLOCKS = 500
_WAIT_S = 0.5
_END_S = 120.0
_REST = 4.0  # times what a look ahead took, before the next
Json = dict[str, Any]  # JSON values
ChooseSource = Callable[[RecordStep], LiveSource | None]


@dataclass(frozen=True, slots=True, kw_only=True)
class Audience:
    """Who looks on while estimators learn; nobody by default.

    Attributes:
        is_there: tells whether anybody looks now.
        tell: takes each new snapshot; must not wait.
    """

    is_there: Callable[[], bool] = lambda: False
    tell: Callable[[Json], None] = lambda snapshot: None


class LiveEstimators:
    """Learns from one record step of a session, the training record.

    While there is an audience, the snapshot also has the provisional estimates of the newest samples; they may
    take a fifth of a processor, so that they come less often where they cost more.

    Args:
        step_name: name of that record step.
        sample_time_s: of the models.
        options: of the identification.
        choose: returns what the samples of a step are.
        audience: who looks on.
        max_blocks: blocks that may wait.
    """

    def __init__(
        self,
        step_name: str,
        sample_time_s: float,
        options: IdentifyOptions,
        choose: ChooseSource,
        *,
        audience: Audience = Audience(),  # frozen
        max_blocks: int = MAX_BLOCKS,
    ) -> None:
        self._step_name = step_name
        self._sample_time_s = sample_time_s
        self._options = options
        self._choose = choose
        self._audience = audience
        self._provisional: Json | None = None
        self._look_ahead_after_s = 0.0
        self._max_blocks = max_blocks
        self._changed = threading.Condition()
        self._waiting: deque[SampleBlock] = deque()
        self._behind = False
        self._over = True
        self._start_tick: int | None = None
        self._samples = {"received": 0, "expected": 0, "lost": 0}
        self._source: LiveSource | None = None
        self._journal = Path()
        self._learner: Learner | None = None
        self._thread: threading.Thread | None = None
        self._snapshot: Json | None = None
        self._catches_up = 0
        self.fit_time_s = 0.0
        self.fit_time_max_s = 0.0

    def snapshot(self) -> Json | None:
        """Return the newest estimates; None before the first record."""
        return self._snapshot

    def begin(self, step: RecordStep, journal: Path) -> None:
        """Get ready for a record; only the training record is learnt from. After a pause all begins anew."""
        if step.name != self._step_name:
            return
        self._source, self._journal = self._choose(step), journal
        if self._source is None:
            return
        self._waiting.clear()
        self._behind, self._over, self._start_tick, self._learner = False, False, None, None
        self._provisional = None
        self._thread = threading.Thread(target=self._run, name="jointscope-estimators", daemon=True)
        self._thread.start()

    def take(self, blocks: list[SampleBlock]) -> None:
        """Take blocks; never waits."""
        with self._changed:
            if self._over:
                return
            for block in blocks:
                if self._behind or len(self._waiting) >= self._max_blocks:
                    self._behind = True
                    break
                self._waiting.append(block)
            self._changed.notify_all()

    def progress(self, progress: RecordProgress) -> None:
        """Take note of the samples' count, and of the excitation's first tick once it is known."""
        received, lost = progress.samples, progress.samples_lost
        with self._changed:
            if self._over:
                return
            self._samples = {"received": received, "expected": received + lost, "lost": lost}
            self._start_tick = progress.start_tick
            self._changed.notify_all()

    def end(self) -> None:
        """Use what waits, and return when the last estimate stands."""
        thread = self._thread
        if thread is None:
            return
        with self._changed:
            self._over = True
            self._changed.notify_all()
        thread.join(_END_S)
        self._thread = None

    def _run(self) -> None:
        try:
            while self._work():
                pass
            if self._learner is not None:
                self._learner.finish()
                self._publish(self._learner, complete=True)
        except Exception:  # noqa: BLE001  # outermost loop: the record goes on without estimates, and says so
            _LOG.exception("the live estimators ended")
            self._snapshot = {**(self._snapshot or {}), "trouble": "the live estimators ended; see the log"}

    def _work(self) -> bool:
        """Use what waits; tells whether more may come."""
        with self._changed:
            if not self._over and (self._start_tick is None or not (self._waiting or self._behind)):
                self._changed.wait(_WAIT_S)
                if self._start_tick is None and not self._over:
                    return True
            blocks, behind, over = list(self._waiting), self._behind, self._over
            self._waiting.clear()
            self._behind = False
        if self._start_tick is None or self._source is None:
            return not over
        if self._learner is None:
            self._learner = Learner(self._source, self._start_tick, self._sample_time_s, self._options)
        self._learn(self._learner, blocks)
        if behind:
            self._catch_up(self._learner)
        return not over or behind

    def _learn(self, learner: Learner, blocks: list[SampleBlock]) -> None:
        for block in blocks:
            begun_s = time.perf_counter()
            if learner.feed(block):
                self._count(time.perf_counter() - begun_s)
        self._publish(learner, complete=False)

    def _catch_up(self, learner: Learner) -> None:
        """Learn from the journal what did not fit into the queue; what was used before is passed over."""
        self._catches_up += 1
        path = self._journal
        if not path.exists():  # the record has ended meanwhile
            path = path.with_name(path.name + ARCHIVE_SUFFIX)
        for block in JournalReader(path).blocks():
            if block.ticks.size and int(block.ticks[-1]) > learner.pipeline.newest_tick:
                learner.feed(block)
        self._publish(learner, complete=False)

    def _publish(self, learner: Learner, *, complete: bool) -> None:
        snapshot = {
            **learner.snapshot(),
            "provisional": None if complete else self._look_ahead(learner),
            "samples": dict(self._samples),
            "complete": complete,
            "caught_up": self._catches_up,
            "fit_time_s": self.fit_time_s,
        }
        self._snapshot = snapshot
        self._audience.tell(snapshot)

    def _look_ahead(self, learner: Learner) -> Json | None:
        if not self._audience.is_there():
            self._provisional = None
        elif time.perf_counter() >= self._look_ahead_after_s:
            begun_s = time.thread_time()  # of the processor: a busy machine should not make them rarer still
            self._provisional = learner.look_ahead()
            self._look_ahead_after_s = time.perf_counter() + _REST * (time.thread_time() - begun_s)
        elif self._provisional is not None and self._provisional["rows"] <= learner.rows:
            self._provisional = None  # overtaken by the final ones
        return self._provisional

    def _count(self, took_s: float) -> None:
        self.fit_time_s = took_s
        self.fit_time_max_s = max(self.fit_time_max_s, took_s)
