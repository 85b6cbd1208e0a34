"""Run a campaign on a rig, follow it, and list what it recorded.

export JOINTSCOPE_TOKEN=js_...
python -m examples.run_campaign config/campaigns/quick.yaml emulated
"""

import sys
from pathlib import Path

from jointscope_client.client import Client


def main(campaign_file: str, rig: str) -> None:
    """Check the campaign, submit it, tell each change until it is done."""
    text = Path(campaign_file).read_text(encoding="utf-8")
    with Client() as client:
        forecast = client.check_campaign(text, rig=rig)  # nothing moves
        print(
            f"{forecast['name']}: {len(forecast['steps'])} steps, {forecast['duration_s']:.0f} s of the rig's time"
        )

        campaign = client.submit_campaign(text, rig=rig)
        told = ""
        for job in client.campaigns.follow(campaign.id):
            progress = job.raw["progress"]
            line = f"{job.state}: {progress['title']}" if progress else job.state
            if line != told:
                print(line)
            told = line
        client.campaigns.wait(campaign.id)  # raises if it did not end well

        for recording in client.recordings.all(campaign=campaign.id):
            print(
                f"{recording.name}: {recording.samples} samples, {recording.samples_lost} lost, id {recording.id}"
            )


if __name__ == "__main__":
    main(*sys.argv[1:])
