"""Sessions, campaigns and analyses: answers of the real service, shortened; secrets are replaced by words."""

from collections.abc import Mapping
from typing import Any

Json = dict[str, Any]  # JSON values
ITEMS: Mapping[str, Json] = {
    "SessionAnswer": {
        "id": "12d4d5c296a748e49f74f3c578a93a6b",
        "name": "joint1",
        "rig_id": "emulated",
        "state": "done",
        "reason": "",
        "possible": [],
        "progress": None,
        "created_by": "lab bench 2",
        "created_at": "2026-11-22T06:23:57.998021Z",
        "started_at": "2026-11-22T06:23:58.415791Z",
        "ended_at": "2026-11-22T06:24:13.343045Z",
        "spec": {
            "name": "joint1",
            "rig_id": "emulated",
            "train": {
                "excitation": {
                    "amplitude_A": 0.8,
                    "offset_A": 0.0,
                    "ramp_s": 0.5,
                    "kind": "multisine",
                    "period_s": 5.0,
                    "lines": 8,
                    "lowest": 1,
                    "step": 1,
                    "seed": 7,
                },
                "duration_s": 20.0,
            },
            "test": None,
            "record": {"layout": "control", "divisor": 1, "centring": True},
            "identify": {"sample_time_s": 0.1, "order": 2, "delay": 1},
            "estimators": [{"name": "rls", "options": {}}],
            "operator": "",
        },
        "figures": {
            "records": {
                "record train (multisine, 20 s)": {
                    "samples_received": 56965,
                    "samples_expected": 56965,
                    "samples_lost": 0,
                    "gaps": 0,
                    "underruns": 0,
                    "predicted_peak_current_A": 0.799978,
                    "predicted_travel_rad": [-0.000651809, 0.272275],
                }
            },
            "identification": {
                "rls": {
                    "parameters": [
                        {"name": "a1", "value": -0.37707, "std": 0.0638462},
                        {"name": "a2", "value": -0.381794, "std": 0.053267},
                        {"name": "b0", "value": 0.184446, "std": 0.00150014},
                        {"name": "b1", "value": 0.0823408, "std": 0.0117713},
                    ],
                    "scores": {
                        "test": {
                            "free_run": {
                                "n": 197,
                                "rmse": 0.00211053,
                                "r2": 0.999719,
                                "r2_adjusted": 0.999713,
                            }
                        }
                    },
                    "warnings": [],
                }
            },
        },
        "live": {
            "time_s": 19.9,
            "rows": 200,
            "segments": 1,
            "sample_time_s": 0.1,
            "lookahead_s": 2.5,
            "estimators": {
                "rls": {
                    "title": "RLS",
                    "parameters": [
                        {"name": "a1", "value": -0.37707, "std": 0.0638462},
                        {"name": "a2", "value": -0.381794, "std": 0.053267},
                        {"name": "b0", "value": 0.184446, "std": 0.00150014},
                        {"name": "b1", "value": 0.0823408, "std": 0.0117713},
                    ],
                    "prediction": -0.0980426,
                    "residual": -0.00114446,
                    "r2_adjusted": 0.999196,
                    "rejected": 0,
                }
            },
            "provisional": None,
            "samples": {"received": 51625, "expected": 51625, "lost": 0},
            "complete": True,
            "caught_up": 0,
            "fit_time_s": 0.00125566,
        },
        "recording_id": "4ad4b68b-7219-4504-b987-a8dfda8ccd84",
    },
    "CampaignAnswer": {
        "id": "2a49cf86e0894ad79f52c4ac6bdb8c43",
        "name": "quick",
        "rig_id": "emulated",
        "state": "done",
        "reason": "",
        "possible": [],
        "progress": None,
        "created_by": "lab bench 2",
        "created_at": "2026-11-22T06:24:13.433722Z",
        "started_at": "2026-11-22T06:24:13.450536Z",
        "ended_at": "2026-11-22T06:24:16.376956Z",
        "position": 1,
        "duration_s": 20.0,
        "items": [
            {
                "position": 0,
                "kind": "record",
                "title": "record train (sine, 20 s)",
                "state": "done",
                "reason": "",
                "figures": {
                    "samples_received": 55244,
                    "samples_expected": 55244,
                    "samples_lost": 0,
                    "gaps": 0,
                    "underruns": 0,
                    "predicted_peak_current_A": 0.501871,
                    "predicted_travel_rad": [-0.00743018, 0.733783],
                },
                "recording_id": "6c8ea5c5-dd86-485a-bec3-3b3cec4d4793",
                "started_at": "2026-11-22T06:24:13.493712Z",
                "ended_at": "2026-11-22T06:24:15.786605Z",
            }
        ],
    },
    "ForecastAnswer": {
        "name": "quick",
        "rig_id": "emulated",
        "duration_s": 20.0,
        "steps": [
            {
                "title": "record train (sine, 20 s)",
                "kind": "record",
                "duration_s": 20.0,
                "samples": 50000,
                "line_use": 0.177067,
                "predicted": {
                    "duration_s": 20.0,
                    "peak_current_a": 0.501517,
                    "rms_current_a": 0.34752,
                    "heat_current_a": 0.373837,
                    "slew_a_s": 0.695504,
                    "peak_speed_rad_s": 0.456855,
                    "position_min_rad": -0.0385153,
                    "position_max_rad": 0.697596,
                },
            }
        ],
    },
    "DiscrepancyAnswer": {
        "id": "6ad11dd1-fe00-4058-8a28-633fb3f1bd70",
        "state": "queued",
        "reason": "",
        "request": {
            "model": "75075956-3c59-40e4-9ea4-a690c78d8fde",
            "train": ["d30343c8-5b47-4e6d-8077-d66bc5cf7406"],
            "test": ["ff901491-6861-4515-a412-2b61c27b24aa"],
        },
        "progress": {},
        "result": {},
        "model_id": None,
        "created_by": "lab bench 2",
        "created_at": "2026-11-22T06:25:00.049883Z",
        "started_at": None,
        "ended_at": None,
    },
}
