"""An example of each request body of the OpenAPI document: whole, so that it can be sent as it stands."""

from collections.abc import Mapping
from typing import Any

Json = dict[str, Any]  # JSON values
_EXCITATION = {"kind": "multisine", "amplitude_A": 0.8, "period_s": 5, "lines": 8, "seed": 7, "ramp_s": 0.5}
_TEST = {"kind": "trapezoid", "amplitude_A": 0.6, "period_s": 4, "rise_fraction": 0.2, "ramp_s": 0.5}
_RECORDINGS = ("4ad4b68b-7219-4504-b987-a8dfda8ccd84", "6c8ea5c5-dd86-485a-bec3-3b3cec4d4793")

# By the name of the body's schema.
BODIES: Mapping[str, Json] = {
    "SessionBody": {
        "name": "joint1",
        "rig": "emulated",
        "excitation": _EXCITATION,
        "duration_s": 20,
        "test": {"excitation": _TEST, "duration_s": 10},
        "estimators": [{"name": "rls", "options": {"forgetting": 0.995}}, {"name": "rls_kf"}],
        "sample_time_s": 0.1,
        "order": 2,
        "operator": "A. Reader",
    },
    "DiscrepancyBody": {
        "model": "75075956-3c59-40e4-9ea4-a690c78d8fde",
        "train": [_RECORDINGS[0]],
        "test": [_RECORDINGS[1]],
    },
    "TokenBody": {"name": "bench 2", "scopes": ["read", "run"], "expires_in_s": 86400},
    "LeaseBody": {"ttl_s": 10, "take_over": False},
    "LeaseRenewal": {"ttl_s": 30},
    "ParameterWrite": {"value": 1.5},
    "CaptureBody": {"layout": "phases", "trigger": "level", "column": "current_A", "level": 1.0},
    "QueueBody": {"order": ["2a49cf86e0894ad79f52c4ac6bdb8c43"], "held": False},
}

# By path and media type, where the endpoint reads the body itself.
DOCUMENTS: Mapping[tuple[str, str], Any] = {  # JSON values, or text
    ("/api/v1/campaigns", "application/json"): {
        "name": "quick",
        "rig": "emulated",
        "steps": [
            {"record": {"name": "train", "duration_s": 20, "excitation": _EXCITATION}},
            {"identify": {"train": "train", "test": "train", "sample_time_s": 0.1}},
        ],
    },
    ("/api/v1/models", "application/json"): {
        "name": "bench",
        "axis": "rotary",
        "input": "current_A",
        "outputs": ["speed_rad_s"],
        "parameters": {
            "inertia": {"value": 0.5, "unit": "kg m^2", "fixed": True},
            "viscous_friction": {"value": 0.9, "unit": "N m s/rad"},
            "torque_constant": {"value": 1.0, "unit": "N m/A"},
        },
    },
    ("/api/v1/recordings", "application/octet-stream"): (
        "time_s,current_A,speed_rad_s\n0.00,0.100,0.000\n0.01,0.120,0.002\n0.02,0.140,0.005\n"
    ),
}
