"""What a session shall do, and the small campaign that it is; errors name the fields of the session's own request."""

from dataclasses import asdict, dataclass, field
from typing import Any

from server.config.campaign import IdentifyStep
from server.errors import InputError, InputLocation
from server.services.errors import InvalidValueError
from server.services.estimator_choice import EstimatorChoice, check_choices, check_length
from server.services.limits import TICK_HZ

TRAIN, TEST = "train", "test"
Json = dict[str, Any]  # JSON values


@dataclass(frozen=True, slots=True, kw_only=True)
class SessionSpec:
    """What to identify and how; excitations as in campaign files.

    Attributes:
        name: of the session.
        rig_id: the rig.
        train: `excitation` and `duration_s` of the training record.
        test: the same of the test record; None scores on the training record.
        record: further settings of both records (`layout`, `divisor`, `centring`).
        identify: settings of the identification (`sample_time_s`, `order`, `delay`).
        estimators: which, with their options.
        operator: written into the recordings; empty takes the token's name.
    """

    name: str
    rig_id: str
    train: Json
    test: Json | None = None
    record: Json = field(default_factory=dict)
    identify: Json = field(default_factory=dict)
    estimators: tuple[EstimatorChoice, ...] = ()
    operator: str = ""

    def to_json(self) -> Json:
        """Return the specification as it is stored."""
        return asdict(self)


def campaign_of(spec: SessionSpec, operator: str) -> Json:
    """Return the campaign that a session is."""
    records = {TRAIN: spec.train, **({} if spec.test is None else {TEST: spec.test})}
    steps: list[Json] = [
        {"record": {"name": name, **spec.record, **record}} for name, record in records.items()
    ]
    scored = TRAIN if spec.test is None else TEST
    estimators = {
        "methods": [each.name for each in spec.estimators],
        "options": check_choices(spec.estimators),
    }
    steps.append({"identify": {"train": TRAIN, "test": scored, **spec.identify, **estimators}})
    return {"name": spec.name, "operator": spec.operator or operator, "steps": steps}


def check_sample_time(spec: SessionSpec) -> None:
    """Refuse sample times that the live estimators could not have in step with the samples."""
    own_s = spec.record.get("divisor", 1) / TICK_HZ
    asked_s = _setting(spec, "sample_time_s")
    ratio = asked_s / own_s
    if ratio < 1 - 1e-6 or abs(ratio - round(ratio)) > 1e-6 * ratio:
        nearest = max(1, round(ratio)) * own_s
        raise InvalidValueError(
            f"sample_time_s={asked_s:g} is no multiple of the record's {own_s:g} s",
            field="sample_time_s",
            value=asked_s,
            remedy=f"use {nearest:g} s",
        )


def check_records(spec: SessionSpec) -> None:
    """Refuse records that are too short for the models that shall come of them.

    Raises:
        InvalidValueError: its field is the record's `duration_s`, or one of the estimators.
    """
    options = check_choices(spec.estimators)
    sample_time_s = _setting(spec, "sample_time_s")
    for prefix, record in (("", spec.train), ("test.", spec.test)):
        if record is None:
            continue
        try:
            check_length(
                int(record["duration_s"] / sample_time_s * (1 + 1e-9)),
                order=_setting(spec, "order"),
                delay=_setting(spec, "delay"),
                methods=[each.name for each in spec.estimators],
                options=options,
            )
        except ValueError as error:
            raise InvalidValueError(
                f"{prefix}duration_s={record['duration_s']:g} at a sample time of {sample_time_s:g} s {error}",
                field=f"{prefix}duration_s",
                value=record["duration_s"],
                remedy="record longer, or lower the sample time, the order or the delay",
            ) from error


def _setting(spec: SessionSpec, name: str) -> Any:  # JSON value
    """Return a setting of the identification, or what a campaign's step has where none is given."""
    return spec.identify.get(name, IdentifyStep.model_fields[name].default)


def named_as_in_the_request(error: InputError) -> InputError:
    """Name the fields as a session's request has them, not as its campaign document does."""
    where = error.location
    text, name = str(error.args[0]).removeprefix(f"{where}: "), where.field or ""
    for mine, theirs in (("steps[0].record.", ""), ("steps[1].record.", "test.")):
        if name.startswith(mine):
            name = theirs + name.removeprefix(mine)
    name = name.partition(".identify.")[2] or name
    return InputError(text, InputLocation(source="session", field=name or None))
