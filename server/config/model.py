"""The base of every configuration model: frozen, and unknown keys are refused with the nearest valid one."""

import difflib
from collections.abc import Iterable
from typing import Any

from pydantic import BaseModel, ConfigDict, model_validator
from pydantic_core import PydanticCustomError

# Put into a step's settings by the loader, not by the user: never offered as a key.
STEP_TAG = "step"


def suggest(name: str, valid: Iterable[str]) -> str:
    """Return `; did you mean "x"?` when a valid name is near, else nothing."""
    near = difflib.get_close_matches(name, list(valid), n=1, cutoff=0.6)
    return f'; did you mean "{near[0]}"?' if near else ""


class StrictModel(BaseModel):
    """A frozen model that names the nearest valid key when it meets one it does not know."""

    # NaN and infinity are legal YAML numbers, and no setting means anything with them.
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, hide_input_in_errors=True)

    @model_validator(mode="before")
    @classmethod
    def _refuse_unknown_keys(cls, data: Any) -> Any:  # Any: whatever stood in the YAML file
        if not isinstance(data, dict):
            return data
        known = [name for name in cls.model_fields if name != STEP_TAG]
        for key in data:
            if key not in cls.model_fields:
                raise PydanticCustomError(
                    "unknown_key",
                    'unknown key "{key}"{suggestion} allowed: {allowed}',
                    {
                        "key": str(key),
                        "suggestion": suggest(str(key), known) or ";",
                        "allowed": ", ".join(known),
                    },
                )
        return data
