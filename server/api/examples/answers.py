"""An example of each main answer; lists are made of the one item that stands beside."""

from collections.abc import Mapping
from typing import Any

from server.api.examples import rigs, store, work

Json = dict[str, Any]  # JSON values
# Lists: their item, and what else they have.
_LISTS: Mapping[str, tuple[str, Json]] = {
    "RigList": ("RigAnswer", {}),
    "ParameterList": ("ParameterAnswer", {}),
    "SessionPage": ("SessionAnswer", {"next_before": None}),
    "CampaignPage": ("CampaignAnswer", {"next_before": None}),
    "RecordingList": ("RecordingAnswer", {"cursor": None}),
    "ModelList": ("ModelAnswer", {"next_offset": None}),
    "DiscrepancyList": ("DiscrepancyAnswer", {"next_offset": None}),
    "EventPage": ("EventAnswer", {"next_after": None}),
    "TokenList": ("TokenAnswer", {}),
    "AuditPage": ("AuditAnswer", {"next_before": None}),
}


def answer_examples() -> dict[str, Json]:
    """Return the example of each answer, by the name of its schema."""
    items = {**rigs.ITEMS, **work.ITEMS, **store.ITEMS}
    lists = {name: {"items": [items[item]], **more} for name, (item, more) in _LISTS.items()}
    queue = {"rig_id": "emulated", "held": False, "waiting": []}
    return {**items, **lists, "QueueAnswer": queue}
