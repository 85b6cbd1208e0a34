"""The JSON object `next_experiment`: what is proposed, why, and what else would settle it."""

from collections.abc import Mapping, Sequence
from typing import Any

from discrepancy.design.discovery import Discovery
from discrepancy.design.excitations import RAMP_S
from discrepancy.design.proposal import Proposal

Entry = Mapping[str, Any]  # Any: values of the JSON object
MOST_TOLD = 3
"""Effects that a reason names one by one."""


def proposed(why: str, separates: Sequence[str], proposal: Proposal) -> dict[str, Any]:
    """Return the answer that an experiment gives: why, what it separates, and how to play it."""
    return {
        "why": why,
        "separates": list(separates),
        "duration_s": proposal.duration_s,
        "excitation": {**proposal.excitation, "ramp_s": RAMP_S},
        "worth": round(proposal.worth, 3),
    }


def revealing(why: str, found: Discovery) -> dict[str, Any]:
    """Return the answer that a look for hidden effects gives, with the strength from which each would show."""
    reveals = [
        {"effect": one.id, "parameter": one.parameter, "unit": one.unit, "now": one.now, "then": one.then}
        for one in found.reveals
    ]
    entry = proposed(why, [one.id for one in found.reveals], found.proposal)
    return {**entry, "reveals": reveals}


def why_hidden(found: Discovery, verdict: str) -> str:
    """Return what a look for hidden effects predicts of those that gain most, after a verdict without names."""
    told = [
        f"{one.id} from a {one.parameter.replace('_', ' ')} of {abs(one.then):.2g} {one.unit} on "
        f"(so far {abs(one.now):.2g})"
        for one in found.reveals[:MOST_TOLD]
    ]
    more = len(found.reveals) - len(told)
    rest = f", and {more} more" if more > 0 else ""
    lead = {
        "none": "an effect weaker than what these records show may still be hidden",
        "unknown": "no effect of the catalogue explains what is left; weak effects beside it may be hidden",
    }
    return f"{lead[verdict]}; this record would show {', '.join(told)}{rest}"


def others(measurements: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return the part of an answer that names measurements with other means."""
    return {"other_measurements": list(measurements)} if measurements else {}


def only_measurement(measurements: Sequence[Mapping[str, Any]]) -> Entry | None:
    """Return the answer where no excitation helps: another sensor or load would."""
    if not measurements:
        return None
    names = list(dict.fromkeys(name for one in measurements for name in one["separates"]))
    return {
        "why": "no current that this rig may be sent tells them apart: another measurement would",
        "separates": names,
        "excitation": {},
        "other_measurements": list(measurements),
    }
