"""Thousands of generated requests against the running service, by its own OpenAPI document, with all checks.

    python -m benchmarks.service_schemathesis [--cases 2000] [--seed 1]

No answer may be a 5xx (but for a rig that does not answer), undocumented, of another shape than documented, or accept
what the document forbids. The endless event stream is left out, and disconnecting. A rig is emulated at full speed, so
that its controller answers as well. Ends with 1 when something was found.
"""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

from benchmarks.service_process import BenchService, running_service

# A rig that was disconnected would answer nothing but 409 from then on.
_LEFT_OUT = ("/api/v1/events/stream", "/api/v1/rigs/{rig_id}/disconnect")
# Valid by the document, yet refused for what it means: there the check "a valid request is accepted" takes 422 as well.
# Every other check stays on for these operations, as this one does for all others.
_MAY_BE_REFUSED = {
    "GET /api/v1/campaigns": "`before` must be the id of a campaign that exists",
    "GET /api/v1/sessions": "`before` must be the id of a session that exists",
    "GET /api/v1/recordings": "`cursor` must be one that the service made, `since` within the calendar in UTC",
    "POST /api/v1/campaigns": "the document is YAML text or JSON whose steps are checked against the rig",
    "POST /api/v1/models": "the document is a model file, whose parameters depend on the model",
    "POST /api/v1/recordings": "the body is a file, which must be what its name says",
    "POST /api/v1/sessions": "each value may be right and the combination not, as divisor with sample_time_s",
    "PUT /api/v1/rigs/{rig_id}/queue": "`order` must name each campaign that waits",
}
# Names that exist: made-up ones would hardly ever get past 404.
# Wrong tokens are among the cases; each must be answered by 401.
_OPTIONS = ("--wrong-tokens", "1000000")
CONFIG = """[parameters]
"path.rig_id" = "{rig}"
"path.name" = "current_limit_A"
"path.token_id" = "{spare}"
"header.Jointscope-Lease" = "{lease}"

[auth.openapi.HTTPBearer]
bearer = "{token}"
"""
_REFUSED = """
[[operations]]
include-name = "{name}"
[operations.checks]
positive_data_acceptance.expected-statuses = ["2xx", "3xx", 401, 403, 404, 409, 422, 429, "5xx"]
"""


def operations(service: BenchService) -> int:
    """Return how many operations are tested."""
    with service.client() as client:
        paths = client.get("/openapi.json").json()["paths"]
    return sum(len(each) for path, each in paths.items() if path not in _LEFT_OUT)


def run(service: BenchService, cases: int, seed: int) -> tuple[int, str]:
    """Run at least so many cases; return the exit code and what was printed."""
    per_operation = max(1, -(-cases // operations(service)))
    program = str(Path(sys.executable).with_name("schemathesis"))
    with service.client() as client, tempfile.TemporaryDirectory(prefix="jointscope-bench-") as folder:
        lease = client.post(f"/api/v1/rigs/{service.rigs[0]}/lease", json={"ttl_s": 3600.0}).json()["id"]
        spare = client.post("/api/v1/tokens", json={"name": "to be revoked", "scopes": ["read"]}).json()
        config = Path(folder) / "schemathesis.toml"
        config.write_text(
            CONFIG.format(rig=service.rigs[0], lease=lease, spare=spare["token"]["id"], token=service.token)
            + "".join(_REFUSED.format(name=name) for name in _MAY_BE_REFUSED)
        )
        command = [program, "--config-file", str(config), "run", f"{service.url}/openapi.json"]
        command += ["--checks", "all", "--seed", str(seed), "--max-examples", str(per_operation)]
        command += ["--request-timeout", "30", "--no-color", "--continue-on-failure"]
        command += ["--phases", "examples,coverage,fuzzing"]
        for path in _LEFT_OUT:
            command += ["--exclude-path", path]
        done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=folder)
    return done.returncode, done.stdout + done.stderr


def main() -> int:
    """Run once and print what was found."""
    parser = argparse.ArgumentParser(description="Generated requests against the service")
    parser.add_argument("--cases", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    with running_service(["emulated"], speed="max", options=_OPTIONS) as service:
        code, printed = run(service, given.cases, given.seed)
    print(printed)
    return code


if __name__ == "__main__":
    sys.exit(main())
