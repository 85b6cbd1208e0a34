"""A proposed experiment as the content of a campaign file that `jointscope run` plays."""

from collections.abc import Mapping
from typing import Any

RECORD_NAME = "next"


def campaign(entry: Mapping[str, Any]) -> dict[str, Any]:
    """Return the campaign file as a mapping; the rig is given on the command line.

    Args:
        entry: `next_experiment` of an answer, with an excitation.
    """
    excitation = dict(entry["excitation"])
    record = {"name": RECORD_NAME, "duration_s": entry["duration_s"], "excitation": excitation}
    return {"name": "next-experiment", "description": entry["why"], "steps": [{"record": record}]}
