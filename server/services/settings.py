"""What whoever starts the service chooses."""

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, slots=True, kw_only=True)
class ServiceSettings:
    """Choices of one service process.

    Attributes:
        data_dir: database, recordings, reports; made if it is not there.
        rigs_dir: folder of rig files, None for no rigs.
        emulate: scenario for rigs whose link is `emulate`; those are connected at once.
        speed: of their emulators: `max`, or a factor of real time.
        database_url: PostgreSQL by URL instead of the SQLite file below `data_dir`.
        allowed_origins: origins of web pages, other than the service's own, that may open a WebSocket.
        max_upload_octets: largest file that may be sent; other bodies have a limit of their own.
        wrong_tokens_per_minute: as many an address may send before it is told to wait.
        keep_events_days: age at which events are forgotten.
        keep_audit_days: the same of the audit log.
        deletion_grace_days: a deleted recording can be taken back for so long.
        analysis_jobs: processes that one discrepancy analysis may use; None takes one for each core.
    """

    data_dir: Path
    rigs_dir: Path | None = None
    emulate: Path | None = None
    speed: str | None = None
    database_url: str | None = None
    allowed_origins: tuple[str, ...] = ()
    max_upload_octets: int = 512 * 1024 * 1024
    wrong_tokens_per_minute: int = 20
    keep_events_days: float = 365.0
    keep_audit_days: float = 1826.0
    deletion_grace_days: float = 30.0
    analysis_jobs: int | None = None
