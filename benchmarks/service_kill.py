"""Kill the service with -9 at random moments of a campaign and start it again: what is lost, and what still runs?

    python -m benchmarks.service_kill [KILLS] [SEED]        (50 and 1 by default; some 10 s each)

Each round queues the campaign of `tests/server/service/killing.py`, waits a random time within its length, kills the
process and starts another one on the same data folder, which grows from round to round. After each restart: every
journal that was open is a recording that is listed and has all of the journal's samples, no job is in a state that only
a living process can have, and no rig is armed, leased or at work.
"""

import random
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from tests.server.service.conftest import RIG, Service, launch
from tests.server.service.killing import Aftermath, kill_and_restart, submit

# The campaign's length with its analysis, s, and a little of what comes before and after it.
LONGEST_S = 16.0


def play_round(service: Service, wait_s: float) -> tuple[Service, Aftermath]:
    """Kill the service `wait_s` after a campaign was queued."""
    client = service.client()
    client.put(f"/api/v1/rigs/{RIG}/queue", json={"held": False})
    campaign = submit(client)
    time.sleep(wait_s)
    data, token = service.data, service.admin_token

    def again() -> Service:
        started = launch(data, speed="1", token=token)
        started.connect()
        return started

    return kill_and_restart(service, campaign, again)


def main() -> int:
    """Play all rounds and print what they found; 1 if anything was out of order."""
    kills = int(sys.argv[1]) if len(sys.argv) > 1 else 50
    moments = random.Random(int(sys.argv[2]) if len(sys.argv) > 2 else 1)
    states: Counter[tuple[str, str]] = Counter()
    recovered, faults = 0, 0
    with tempfile.TemporaryDirectory() as folder:
        service = launch(Path(folder) / "data", speed="1")
        service.connect()
        for number in range(1, kills + 1):
            wait_s = moments.uniform(0.0, LONGEST_S)
            service, aftermath = play_round(service, wait_s)
            states[aftermath.state] += 1
            recovered += aftermath.recovered
            faults += bool(aftermath.faults)
            for fault in aftermath.faults:
                print(f"round {number}, killed after {wait_s:.2f} s: {fault}", flush=True)
        service.stop()
    for (before, after), count in sorted(states.items()):
        print(f"{count:4} times {before} -> {after}")
    print(f"{kills} kills, {recovered} open journals recovered, {faults} rounds out of order")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
