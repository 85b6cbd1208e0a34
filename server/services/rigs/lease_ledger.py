"""Who held which rig from when to when, in the database; the live lease itself is in memory only."""

import hashlib

from server.services.rigs.lease import Grant, LeaseEnd
from server.storage.database import Database
from server.storage.tables import LeaseRow
from server.storage.types import utc_now


class LeaseLedger:
    """Writes down leases. Their ids are secrets, so what is stored is a hash.

    Args:
        database: where they are kept.
    """

    def __init__(self, database: Database) -> None:
        self._database = database

    def begin(self, rig_id: str, grant: Grant) -> None:
        """Write down a lease just granted."""
        row = LeaseRow(id=_key(grant), rig_id=rig_id, token_id=grant.token_id, holder=grant.holder)
        with self._database.write() as session:
            session.add(row)

    def end(self, grant: Grant, how: LeaseEnd) -> None:
        """Write down how it ended."""
        with self._database.write() as session:
            row = session.get(LeaseRow, _key(grant))
            if row is not None:
                row.ended_at, row.ended_by = utc_now(), how.value


def _key(grant: Grant) -> str:
    return hashlib.sha256(grant.id.encode()).hexdigest()[:32]
