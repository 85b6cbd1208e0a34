"""Sessions and campaigns as JSON."""

from datetime import datetime
from typing import Annotated, Any, Literal

from pydantic import Field, StrictBool

from server.api.schemas.base import Answer, Request
from server.config.campaign import StepName
from server.config.excitation import Excitation
from server.config.units import Seconds
from server.services.estimator_choice import EstimatorChoice
from server.services.jobs.machine import Happening, JobState
from server.services.session_spec import SessionSpec

Json = dict[str, Any]  # JSON values
JOB_ID_PATTERN = "^[0-9a-f]{32}$"
EXCITATION = {
    "kind": "multisine",
    "amplitude_A": 0.8,
    "period_s": 5,
    "lines": 8,
    "seed": 7,
    "ramp_s": 0.5,
}


class RecordBody(Request):
    """One excitation and how long it is recorded."""

    excitation: Excitation = Field(description="As in campaign files.", examples=[EXCITATION])
    duration_s: Annotated[Seconds, Field(gt=0, le=86_400)] = Field(examples=[20])


class EstimatorBody(Request):
    """One estimator with its options."""

    name: str = Field(max_length=40, examples=["rls"])
    options: dict[str, float] = Field(default_factory=dict, max_length=20, examples=[{"forgetting": 0.99}])


_ESTIMATORS = [EstimatorBody(name=name) for name in ("rls", "erls", "rls_kf")]


class SessionBody(RecordBody):
    """An identification session: a training record, perhaps a test record, and what to estimate."""

    name: StepName = Field(default="session", examples=["joint1"])
    rig: str = Field(max_length=80, examples=["emulated"])
    test: RecordBody | None = Field(
        default=None, description="Recorded after the training; without it the training record scores."
    )
    estimators: Annotated[list[EstimatorBody], Field(min_length=1, max_length=20)] = _ESTIMATORS
    sample_time_s: Annotated[float, Field(gt=0, le=10)] = Field(
        default=0.2, description="Of the models; a multiple of the record's."
    )
    order: Annotated[int, Field(ge=1, le=8)] = 2
    delay: Annotated[int, Field(ge=1, le=50)] = 1
    layout: Literal["control", "phases", "speed"] = "control"
    divisor: Annotated[int, Field(ge=1, le=2_500)] = 1
    centring: StrictBool = Field(default=True, description="Hold the joint's mean position.")
    operator: str = Field(
        default="", max_length=120, description="Who is responsible; else the token's name."
    )

    def to_spec(self) -> SessionSpec:
        """Return what the service takes."""
        return SessionSpec(
            name=self.name,
            rig_id=self.rig,
            train={"excitation": self.excitation.model_dump(mode="json"), "duration_s": self.duration_s},
            test=None if self.test is None else self.test.model_dump(mode="json"),
            record={"layout": self.layout, "divisor": self.divisor, "centring": self.centring},
            identify={
                "sample_time_s": self.sample_time_s,
                "order": self.order,
                "delay": self.delay,
            },
            estimators=tuple(
                EstimatorChoice(name=each.name, options=each.options) for each in self.estimators
            ),
            operator=self.operator,
        )


class ProgressAnswer(Answer):
    """Where a running job is."""

    step: int = Field(description="Index of the step under way.")
    steps: int
    title: str
    done_s: float = Field(description="Of the step, in the rig's own time.")
    total_s: float
    detail: str
    samples_received: int = Field(description="Of the record under way.")
    samples_expected: int
    samples_lost: int
    notes: list[str]


class JobAnswer(Answer):
    """What sessions and campaigns have in common."""

    id: str
    name: str
    rig_id: str
    state: JobState
    reason: str = Field(description="Why it ended or was refused; empty while there is nothing to say.")
    possible: list[Happening] = Field(description="What may be asked for now.")
    progress: ProgressAnswer | None = Field(description="Only while it runs.")
    created_by: str
    created_at: datetime
    started_at: datetime | None
    ended_at: datetime | None


class SessionAnswer(JobAnswer):
    """One session."""

    spec: Json
    figures: Json = Field(description="Samples of each record; at the end the parameters and scores.")
    live: Json | None = Field(description="Estimates while the training record is made.")
    recording_id: str | None = Field(description="The training record.")


class SessionPage(Answer):
    """Newest first; `next_before` continues, null at the end."""

    items: list[SessionAnswer]
    next_before: str | None


class ItemAnswer(Answer):
    """One step of a campaign."""

    position: int
    kind: str = Field(examples=["record"])
    title: str
    state: JobState
    reason: str
    figures: Json
    recording_id: str | None
    started_at: datetime | None
    ended_at: datetime | None


class CampaignAnswer(JobAnswer):
    """One campaign."""

    position: int = Field(description="Place in its rig's queue; lower ones run first.")
    duration_s: float = Field(description="Predicted, in the rig's own time.")
    items: list[ItemAnswer]


class CampaignPage(Answer):
    """Newest first; `next_before` continues, null at the end."""

    items: list[CampaignAnswer]
    next_before: str | None


class StepForecastAnswer(Answer):
    """What one step would do."""

    title: str
    kind: str
    duration_s: float
    samples: int | None
    line_use: float | None = Field(description="Share of the serial line.")
    predicted: dict[str, float] | None = Field(description="Currents, speed and travel; SI.")


class ForecastAnswer(Answer):
    """What a campaign would do; nothing moved."""

    name: str
    rig_id: str
    duration_s: float
    steps: list[StepForecastAnswer]


class QueueAnswer(Answer):
    """The campaigns that wait for a rig, first to run first."""

    rig_id: str
    held: bool = Field(description="True: nothing is begun until the queue is released, as after a restart.")
    waiting: list[CampaignAnswer]


class QueueBody(Request):
    """A change of the queue."""

    order: (
        Annotated[
            list[Annotated[str, Field(pattern=JOB_ID_PATTERN)]],
            Field(max_length=10_000, json_schema_extra={"uniqueItems": True}),
        ]
        | None
    ) = Field(default=None, description="Ids of all waiting campaigns in their new order, each once.")
    held: StrictBool | None = None
