"""Line use as computed in docs/protocol.md beside what the emulated controller counted.

    python -m benchmarks.wire_counters

For each layout the controller streams a minute of samples; its LINK_STATS counter of sent octets before and after gives
the octets for one second of stream. What it sends besides the stream (STATUS, events, replies) is listed apart.
"""

from benchmarks.emulated import emulated_controller
from daq.driver.options import RigOptions, StreamPlan
from daq.driver.rig import Rig, open_rig
from daq.protocol.budget import line_use, wire_efficiency, wire_octets
from daq.protocol.commands import LinkStats
from daq.protocol.replies import LinkStatsReply

SECONDS = 60
BAUD = 937_500
BATCH = {"control": 25, "phases": 24, "speed": 25}
CHANNELS = {"control": 3, "phases": 5, "speed": 4}


def count_octets(rig: Rig, layout: str) -> tuple[int, int, int, int]:
    """Stream for `SECONDS` of device time; return samples, frames and octets sent, and frames that were no stream."""
    before = rig.ask(LinkStats())
    assert isinstance(before, LinkStatsReply)  # noqa: S101  # the reply class belongs to the command
    rig.start_stream(StreamPlan(layout=layout, batch=BATCH[layout]))
    samples = 0
    while samples < SECONDS * rig.hello.tick_hz:
        samples += sum(block.ticks.size for block in rig.next_blocks(0.5))
    rig.stop_stream()
    samples += sum(block.ticks.size for block in rig.next_blocks(0.5))
    after = rig.ask(LinkStats())
    assert isinstance(after, LinkStatsReply)  # noqa: S101  # the reply class belongs to the command
    frames = after.tx_frames - before.tx_frames
    return samples, frames, after.tx_octets - before.tx_octets, frames - -(-samples // BATCH[layout])


def main() -> None:
    """Print the table."""
    print(
        "| layout | batch | octets a frame | efficiency | line use computed | line use counted | of it not stream |"
    )
    print("|---|---|---|---|---|---|---|")
    with emulated_controller("20") as port, open_rig(port, RigOptions(baud=BAUD)) as rig:
        for layout, channels in CHANNELS.items():
            batch = BATCH[layout]
            samples, frames, octets, other_frames = count_octets(rig, layout)
            seconds = samples / rig.hello.tick_hz
            stream_octets = (frames - other_frames) * wire_octets(channels, batch)
            counted = octets * 10 / seconds / BAUD
            print(
                f"| {layout} | {batch} | {wire_octets(channels, batch)} | {wire_efficiency(channels, batch):.1%} "
                f"| {line_use(BAUD, channels, batch, 1, rig.hello.tick_hz):.2%} | {counted:.2%} "
                f"| {(octets - stream_octets) / octets:.2%} |"
            )


if __name__ == "__main__":
    main()
