"""The queue of each rig: which campaigns wait, in which order, whether they are held, and whose turn it is.

One thread looks after all queues: the first campaign in line begins when its rig is free (no job, no lease of somebody
else). Queues that hold campaigns at the start of the service are held.
"""

import logging
import threading
from collections.abc import Callable

import sqlalchemy as sa

from server.services.errors import ConflictError, InvalidValueError
from server.services.jobs.board import JobBoard
from server.services.jobs.held_lease import check_free
from server.services.rigs.registry import RigRegistry
from server.services.rigs.served_rig import ServedRig
from server.services.tokens import Principal, Scope
from server.storage.database import Database
from server.storage.states import JobState
from server.storage.tables import CampaignRow

_LOG = logging.getLogger(__name__)
_LOOK_S = 0.5


class CampaignQueues:
    """The queues of all rigs.

    Args:
        database: where campaigns are kept.
        rigs: whose queues these are.
        board: what runs now.
        begin: starts a campaign whose turn it is.
    """

    def __init__(
        self,
        database: Database,
        rigs: RigRegistry,
        board: JobBoard,
        begin: Callable[[ServedRig, CampaignRow], None],
    ) -> None:
        self._database = database
        self._rigs = rigs
        self._board = board
        self._begin = begin
        self._news = threading.Event()
        self._closing = threading.Event()
        self._held = {row.rig_id for row in self.waiting(None)}
        self._thread = threading.Thread(target=self._mind, name="jointscope-queues", daemon=True)
        self.changing = threading.Lock()
        """Held by whoever changes a queue."""

    def start(self) -> None:
        """Begin to look after the queues."""
        self._thread.start()

    def close(self) -> None:
        """Begin no further campaign."""
        self._closing.set()
        self._news.set()
        if self._thread.is_alive():
            self._thread.join()

    def look(self) -> None:
        """Look at the queues soon: something has changed."""
        self._news.set()

    def waiting(self, rig_id: str | None) -> list[CampaignRow]:
        """Return the campaigns that wait for a rig, or for any, first to run first."""
        query = sa.select(CampaignRow).where(CampaignRow.state == JobState.QUEUED.value)
        if rig_id is not None:
            query = query.where(CampaignRow.rig_id == rig_id)
        with self._database.read() as session:
            return list(session.scalars(query.order_by(CampaignRow.position, CampaignRow.created_at)))

    def length(self, rig_id: str) -> int:
        """Return how many campaigns wait for a rig."""
        query = sa.select(sa.func.count()).select_from(CampaignRow)
        query = query.where(CampaignRow.state == JobState.QUEUED.value, CampaignRow.rig_id == rig_id)
        with self._database.read() as session:
            return session.scalar(query) or 0

    def last_position(self, rig_id: str) -> int:
        """Return the place of the last one in line."""
        return max((row.position for row in self.waiting(rig_id)), default=0)

    def is_held(self, rig_id: str) -> bool:
        """Tell whether nothing is begun from this queue."""
        return rig_id in self._held

    def hold(self, rig_id: str, *, held: bool) -> None:
        """Hold a queue, or release it."""
        (self._held.add if held else self._held.discard)(rig_id)

    def reorder(self, rig_id: str, order: list[str]) -> None:
        """Put a queue into another order.

        Raises:
            InvalidValueError: `order` does not name exactly those that wait.
        """
        waiting = [row.id for row in self.waiting(rig_id)]
        if sorted(order) != sorted(waiting):
            raise InvalidValueError(
                "order must name each waiting campaign once",
                field="order",
                value=", ".join(order),
                remedy=f"these wait: {', '.join(waiting) or 'none'}",
            )
        with self._database.write() as session:
            for position, job_id in enumerate(order, start=1):
                session.execute(
                    sa.update(CampaignRow).where(CampaignRow.id == job_id).values(position=position)
                )

    def _mind(self) -> None:
        while not self._closing.is_set():
            self._news.wait(_LOOK_S)
            self._news.clear()
            try:
                for rig in self._rigs.all():
                    self._begin_next(rig)
            except Exception:  # noqa: BLE001  # outermost loop: the next look may succeed
                _LOG.exception("the campaign queues could not be looked after")

    def _begin_next(self, rig: ServedRig) -> None:
        with self.changing:
            if self._closing.is_set() or rig.id in self._held or not self._board.is_free(rig.id):
                return
            waiting = self.waiting(rig.id)
            if not waiting:
                return
            try:
                check_free(rig, owner_of(waiting[0]))
            except ConflictError:  # at work for somebody else: the campaign waits
                return
            self._begin(rig, waiting[0])


def owner_of(row: CampaignRow) -> Principal:
    """Return who submitted a campaign, or queued it again."""
    owner = row.document["owner"]
    scopes = frozenset(Scope(scope) for scope in owner["scopes"])
    return Principal(token_id=owner["token_id"], name=owner["name"], scopes=scopes)
