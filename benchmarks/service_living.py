"""Hooks of schemathesis (`SCHEMATHESIS_HOOKS`): they give each operation something that exists and can be worked on.

Generated ids exist never, so that an operation on a session or a recording would be answered by 404 and nothing else
of it be tested. Here each operation on one gets what it can succeed with: a session to be paused runs, a recording
to be taken back is deleted. The first cases of an operation get a new one each, the others the last one,
in the state in which those before left it. One case in ten keeps its made-up id. Cases that are wrong on purpose in
the same part of the request are left alone. Every answer is counted into the file that `ANSWERS` names.
"""

import json
import os
import time
from collections import Counter, defaultdict
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import httpx
import schemathesis
import yaml
from schemathesis.core.parameters import ParameterLocation

from tests.server.service.measured import MODEL, as_csv, measured_columns

URL, TOKEN, ANSWERS = "JOINTSCOPE_URL", "JOINTSCOPE_TOKEN", "JOINTSCOPE_ANSWERS"
# Id of an analysis that is done: made once before the run, since it takes a minute.
FINISHED = "JOINTSCOPE_FINISHED"
# How many cases of an operation get something of their own.
FRESH = "JOINTSCOPE_FRESH"
WITH_BODY = 4
MADE_UP_EVERY = 10
OPERATED, WORKING = "emulated", "working"
_PATIENCE_S = 60.0
_SINE = {"kind": "sine", "amplitude_A": 0.3, "period_s": 2.0, "ramp_s": 0.5}
Case = Any  # a generated request; the library has it without types


class World:
    """What the operations work on, made over the same API.

    Args:
        client: of an admin.
    """

    def __init__(self, client: httpx.Client) -> None:
        self._client = client

    def post(self, path: str, **options: Any) -> Any:  # Any: JSON values
        """Post and return the answer's content; nothing here may be refused."""
        answer = self._client.post(f"/api/v1/{path}", **options)
        answer.raise_for_status()
        return answer.json()

    def recording(self, seed: int = 1, samples: int = 500) -> str:
        """Upload a measured file."""
        content = as_csv(measured_columns(seed, samples))
        return str(self.post("recordings", params={"file": "living.csv"}, content=content)["id"])

    def deleted(self) -> str:
        """Upload and delete."""
        made = self.recording()
        self._client.delete(f"/api/v1/recordings/{made}").raise_for_status()
        return made

    def model(self) -> str:
        """Add a version of a model."""
        return str(self.post("models", content=MODEL)["id"])

    def token(self) -> str:
        """Make a token to be revoked."""
        return str(self.post("tokens", json={"name": "to be revoked", "scopes": ["read"]})["token"]["id"])

    def session(self, duration_s: float = 5.0) -> str:
        """Create a session."""
        body = {"name": "living", "rig": WORKING, "duration_s": duration_s, "excitation": _SINE}
        return str(self.post("sessions", json=body)["id"])

    def running_session(self) -> str:
        """Start a session that is far from its end; the ones before are ended first."""
        self.end_all()
        made = self.session(duration_s=3600.0)
        self.post(f"sessions/{made}/start")
        self.wait("sessions", made, "running")
        return made

    def startable_session(self) -> str:
        """Create a session whose rig is free."""
        self.end_all()
        return self.session()

    def done_session(self) -> str:
        """Play a session to its end."""
        made = self.startable_session()
        self.post(f"sessions/{made}/start")
        self.wait("sessions", made, "done")
        return made

    def paused(self, kind: str, made: str) -> str:
        """Pause what runs."""
        self.post(f"{kind}/{made}/pause")
        self.wait(kind, made, "paused")
        return made

    def campaign(self) -> str:
        """Queue a campaign behind a held queue."""
        self._hold(held=True)
        body = {"name": "living", "steps": [self.step()]}
        return str(self.post("campaigns", params={"rig": WORKING}, json=body)["id"])

    def step(self) -> dict[str, Any]:  # JSON values
        """Return a campaign's step that takes an hour of the rig's time."""
        return {"record": {"name": "one", "duration_s": 3600.0, "excitation": _SINE}}

    def running_campaign(self) -> str:
        """Let a campaign begin, alone in its queue."""
        self.end_all()
        made = self.campaign()
        self._hold(held=False)
        self.wait("campaigns", made, "running")
        self._hold(held=True)
        return made

    def cancelled_campaign(self) -> str:
        """Queue a campaign and cancel it."""
        made = self.campaign()
        self.post(f"campaigns/{made}/stop")
        return made

    def analysis(self) -> str:
        """Queue an analysis."""
        return str(self.post("discrepancies", json=self.analysis_body())["id"])

    def analysis_body(self) -> dict[str, Any]:  # JSON values
        """Return what an analysis can be asked for with."""
        train, test = (self.recording(seed, samples=3000) for seed in (1, 2))
        return {"model": self.model(), "train": [train], "test": [test]}

    def lease(self) -> str:
        """Take the operated rig, from whoever has it, and clear its fault."""
        lease = str(self.post(f"rigs/{OPERATED}/lease", json={"take_over": True, "ttl_s": 600.0})["id"])
        headers = {"Jointscope-Lease": lease}
        self._client.post(f"/api/v1/rigs/{OPERATED}/clear-fault", headers=headers)
        return lease

    def end_all(self) -> None:
        """Bring the working rig to rest: end its sessions and campaigns, empty its queue."""
        self._hold(held=True)
        for kind in ("sessions", "campaigns"):
            listed = self._client.get(f"/api/v1/{kind}", params={"rig_id": WORKING, "limit": 500}).json()
            for each in listed["items"]:
                if "abort" in each["possible"] and each["state"] != "created":
                    self._client.post(f"/api/v1/{kind}/{each['id']}/abort")
                    self.wait(kind, each["id"], "aborted", "cancelled", "done", "failed", "stopped")

    def wait(self, kind: str, made: str, *states: str) -> None:
        """Wait until a session or campaign is in one of these states."""
        deadline_s = time.monotonic() + _PATIENCE_S
        while time.monotonic() < deadline_s:
            view = self._client.get(f"/api/v1/{kind}/{made}").json()
            if view["state"] in states:
                return
            time.sleep(0.02)
        raise TimeoutError(f"{kind} {made} is {view['state']}, not one of {states}: {view['reason']}")

    def _hold(self, *, held: bool) -> None:
        self._client.put(f"/api/v1/rigs/{WORKING}/queue", json={"held": held})


def _give_campaign(world: World, case: Case) -> None:
    case.query = {"rig": WORKING}
    # An object whatever the media type: octets would count as a body that breaks the schema on purpose.
    case.body = {"name": "living", "steps": [world.step()]}


def _give_model(world: World, case: Case) -> None:
    case.query, case.body = {}, yaml.safe_load(MODEL)


def _give_recording(world: World, case: Case) -> None:
    case.query, case.body = {"file": "living.csv"}, as_csv(measured_columns(n=500))


def _give_analysis(world: World, case: Case) -> None:
    case.body = world.analysis_body()


# What is accepted only as a whole, so that no generated one would be.
BODIES: Mapping[str, Callable[[World, Case], None]] = {
    "POST /api/v1/campaigns": _give_campaign,
    "POST /api/v1/models": _give_model,
    "POST /api/v1/recordings": _give_recording,
    "POST /api/v1/discrepancies": _give_analysis,
}
# What an operation needs beyond what any of its kind would do.
SUPPLIES: Mapping[str, Callable[[World], str]] = {
    "GET /api/v1/sessions/{session_id}/identification": World.done_session,
    "POST /api/v1/sessions/{session_id}/start": World.startable_session,
    "POST /api/v1/sessions/{session_id}/pause": World.running_session,
    "POST /api/v1/sessions/{session_id}/resume": lambda world: world.paused(
        "sessions", world.running_session()
    ),
    "POST /api/v1/campaigns/{campaign_id}/pause": World.running_campaign,
    "POST /api/v1/campaigns/{campaign_id}/resume": lambda world: world.paused(
        "campaigns", world.running_campaign()
    ),
    "POST /api/v1/campaigns/{campaign_id}/requeue": World.cancelled_campaign,
    "POST /api/v1/recordings/{recording_id}/undelete": World.deleted,
    "POST /api/v1/recordings/{recording_id}/purge": World.deleted,
}
BY_PARAMETER: Mapping[str, Callable[[World], str]] = {
    "session_id": World.session,
    "campaign_id": World.campaign,
    "recording_id": lambda world: world.recording(),
    "model_id": World.model,
    "analysis_id": World.analysis,
    "token_id": World.token,
}
_OF_FINISHED = ("/gap", "/report")


class Supplier:
    """Puts what exists into generated requests.

    Args:
        world: makes it.
        finished: id of an analysis that is done.
        fresh_cases: so many cases of each operation get something new.
    """

    def __init__(self, world: World, finished: str, fresh_cases: int) -> None:
        self._fresh_cases = fresh_cases
        self._world = world
        self._finished = finished
        self._seen: Counter[str] = Counter()
        self._given: Counter[str] = Counter()
        self._last: dict[str, str] = {}

    def prepare(self, case: Case) -> None:
        """Replace made-up ids, bodies and leases of one request."""
        label = f"{case.method} {case.path}"
        self._seen[label] += 1
        if self._seen[label] % MADE_UP_EVERY == 0:
            return
        for name in BY_PARAMETER.keys() & (case.path_parameters or {}):
            if _is_right(case, ParameterLocation.PATH):
                case.path_parameters[name] = self._id(label, name)
        lease = (case.headers or {}).get("Jointscope-Lease")
        if lease is not None and _is_right(case, ParameterLocation.HEADER):
            case.headers["Jointscope-Lease"] = self._fresh(label, World.lease)
        if label in BODIES and self._given[label] < WITH_BODY and _is_all_right(case):
            self._given[label] += 1
            BODIES[label](self._world, case)

    def _id(self, label: str, name: str) -> str:
        if label.endswith(_OF_FINISHED):
            return self._finished
        return self._fresh(label, SUPPLIES.get(label, BY_PARAMETER[name]))

    def _fresh(self, label: str, make: Callable[[World], str]) -> str:
        if self._seen[label] <= self._fresh_cases or label not in self._last:
            self._last[label] = make(self._world)
        return self._last[label]


def _is_right(case: Case, location: ParameterLocation) -> bool:
    """Tell whether this part of the request is not wrong on purpose."""
    component = None if case.meta is None else case.meta.components.get(location)
    return component is None or bool(component.mode.is_positive)


def _is_all_right(case: Case) -> bool:
    whole = case.meta is None or bool(case.meta.generation.mode.is_positive)
    return whole and all(_is_right(case, each) for each in ParameterLocation)


def install() -> None:
    """Register the hooks, for the service that the environment names."""
    headers = {"Authorization": f"Bearer {os.environ[TOKEN]}"}
    client = httpx.Client(base_url=os.environ[URL], headers=headers, timeout=_PATIENCE_S)
    world = World(client)
    answers: defaultdict[str, Counter[str]] = defaultdict(Counter)
    supplier = Supplier(world, os.environ[FINISHED], int(os.environ[FRESH]))

    def before_call(context: object, case: Case, kwargs: object) -> None:
        supplier.prepare(case)

    def after_call(context: object, case: Case, response: Any) -> None:  # Any: without types as well
        answers[f"{case.method} {case.path}"][str(response.status_code)] += 1
        Path(os.environ[ANSWERS]).write_text(json.dumps(answers), encoding="utf-8")

    for hook in (before_call, after_call):
        schemathesis.hook(hook)


if URL in os.environ:
    install()
