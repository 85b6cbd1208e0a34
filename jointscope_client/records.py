"""What the service tells, as records. `raw` is the whole answer, with what these records do not name."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from datetime import datetime
from typing import Any, TypeVar

T = TypeVar("T")
Json = Mapping[str, Any]  # JSON values


@dataclass(frozen=True, slots=True, kw_only=True)
class Rig:
    """A rig at a glance.

    Attributes:
        connection: `connected`, `disconnected`, ...
        trouble: what goes wrong now; empty when nothing does.
        armed: whether the service has switched the drive on.
    """

    id: str
    description: str = ""
    emulated: bool = False
    connection: str = ""
    trouble: str = ""
    armed: bool = False
    raw: Json = field(default_factory=dict, repr=False)

    @property
    def drive_state(self) -> str | None:
        """Return `idle`, `armed`, `running`, `ramping`, `safe_timeout` or `fault`; None while not connected."""
        drive = self.raw.get("drive")
        return None if drive is None else str(drive["state"])


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameter:
    """A parameter of the controller with its unit and limits."""

    name: str
    value: float | int
    unit: str = ""
    minimum: float | None = None
    maximum: float | None = None
    raw: Json = field(default_factory=dict, repr=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordingInfo:
    """A recording without its samples."""

    id: str
    name: str
    origin: str
    rig_id: str | None = None
    session_id: str | None = None
    campaign_id: str | None = None
    samples: int = 0
    samples_lost: int = 0
    duration_s: float = 0.0
    sample_time_s: float | None = None
    size_octets: int = 0
    columns: Mapping[str, str] = field(default_factory=dict)
    created_by: str = ""
    created_at: datetime
    deleted_at: datetime | None = None
    raw: Json = field(default_factory=dict, repr=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class Model:
    """One version of a joint's model; `document` is the model file's content."""

    id: str
    name: str
    version: int
    note: str = ""
    effects: list[str] = field(default_factory=list)
    document: Json = field(default_factory=dict, repr=False)
    lineage: list[Json] = field(default_factory=list)
    created_at: datetime
    raw: Json = field(default_factory=dict, repr=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class Analysis:
    """A discrepancy analysis; `result` is the heart of its `gap.json`, `model_id` the extended model."""

    id: str
    state: str
    reason: str = ""
    progress: Json = field(default_factory=dict)
    result: Json = field(default_factory=dict)
    model_id: str | None = None
    raw: Json = field(default_factory=dict, repr=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class Job:
    """A session or a campaign; what it is at stands in `raw`."""

    id: str
    rig_id: str
    name: str = ""
    state: str
    reason: str = ""
    raw: Json = field(default_factory=dict, repr=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class Event:
    """One thing that happened."""

    id: int
    at: datetime
    rig_id: str
    kind: str
    text: str = ""
    tick: int | None = None
    data: Json = field(default_factory=dict)
    raw: Json = field(default_factory=dict, repr=False)


def reader(kind: type[T]) -> Callable[[Json], T]:
    """Return what makes a record of this kind of an answer; keys that it does not know stay in `raw`."""
    names = [each.name for each in fields(kind)]  # type: ignore[arg-type]  # all of them are the records above
    make: Callable[..., T] = kind
    moments = [name for name in names if name.endswith("_at") or name == "at"]

    def read(answer: Json) -> T:
        known = {name: answer[name] for name in names if name in answer}
        for name in moments:
            if isinstance(known.get(name), str):
                known[name] = datetime.fromisoformat(known[name])
        return make(**known, raw=answer)

    return read


read_rig, read_parameter, read_recording = reader(Rig), reader(Parameter), reader(RecordingInfo)
read_model, read_analysis, read_job, read_event = reader(Model), reader(Analysis), reader(Job), reader(Event)
