"""An identification session as it runs: the messages of docs/live.md as records. No I/O here."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from jointscope_client.calls import path_of
from jointscope_client.records import Json

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LiveEstimate:
    """What one estimator has learnt so far.

    Attributes:
        names: of the parameters.
        values, errors: parameters and their standard errors, shape (n,); NaN where there is none yet.
        prediction: of the newest output, one step ahead; None before the first.
        residual: by how much the newest output differs from it.
        r2_adjusted: of the predictions so far.
    """

    names: tuple[str, ...]
    values: Floats
    errors: Floats
    prediction: float | None
    residual: float | None
    r2_adjusted: float | None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SessionMoment:
    """A session at one moment.

    Attributes:
        state, reason: as in `Job`.
        estimates: by estimator, on all rows whose samples have been filtered to the end; a replay gives the same.
        time_s: of the newest of these rows, from the excitation's beginning.
        provisional: by estimator, with the rows up to the newest sample, which may still change a little; empty
            where there are none.
        provisional_time_s: of the newest of those rows.
        samples_received, samples_expected, samples_lost: of the training record.
        newest_ns: wall clock of the newest sample in the provisional estimates, ns since 1970; 0 when unknown.
        sent_ns: wall clock when this was sent, ns since 1970.
        skipped: estimates that were replaced by newer ones before you read them.
        raw: the whole message.
    """

    state: str
    reason: str
    estimates: Mapping[str, LiveEstimate]
    time_s: float
    provisional: Mapping[str, LiveEstimate]
    provisional_time_s: float | None
    samples_received: int
    samples_expected: int
    samples_lost: int
    newest_ns: int
    sent_ns: int
    skipped: int
    raw: Json = field(repr=False)


def session_url(url: str, session_id: str, interval_ms: int) -> str:
    """Return the address of a session's live estimates."""
    return f"ws{url.removeprefix('http')}{path_of('sessions', session_id, 'live')}?interval_ms={interval_ms}"


def read_moment(message: str | bytes) -> SessionMoment:
    """Return the moment that a message tells."""
    content = json.loads(message)
    live = content["live"] or {}
    provisional = live.get("provisional") or {}
    samples = live.get("samples", {})
    return SessionMoment(
        state=content["state"],
        reason=content["reason"],
        estimates=_estimates(live),
        time_s=live.get("time_s", 0.0),
        provisional=_estimates(provisional),
        provisional_time_s=provisional.get("time_s"),
        samples_received=samples.get("received", 0),
        samples_expected=samples.get("expected", 0),
        samples_lost=samples.get("lost", 0),
        newest_ns=content["newest_ns"],
        sent_ns=content["sent_ns"],
        skipped=content["skipped"],
        raw=content,
    )


def _estimates(content: Json) -> Mapping[str, LiveEstimate]:
    found = content.get("estimators", {})
    return {name: _estimate(each) for name, each in found.items() if each.get("parameters")}


def _estimate(content: Json) -> LiveEstimate:
    parameters = content["parameters"]
    return LiveEstimate(
        names=tuple(each["name"] for each in parameters),
        values=_floats([each["value"] for each in parameters]),
        errors=_floats([each["std"] for each in parameters]),
        prediction=content["prediction"],
        residual=content["residual"],
        r2_adjusted=content["r2_adjusted"],
    )


def _floats(values: list[float | None]) -> Floats:
    return np.array([np.nan if value is None else value for value in values], dtype=np.float64)
