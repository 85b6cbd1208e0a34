"""Decoding speed of the stream path, and the efficiency of the wire.

Frames of 25 samples go through `FrameDecoder` and `StreamAssembler` in reads of several sizes, as a port or a
journal would bring them. Run: `python benchmarks/protocol_decode.py`.
"""

import time

import numpy as np

from daq.protocol.budget import line_use, wire_efficiency, wire_octets
from daq.protocol.codes import LayoutId
from daq.protocol.dictionary import Dictionary
from daq.protocol.dictionary_entries import Channel, CountType, Layout
from daq.protocol.framing import FrameDecoder, encode_frame
from daq.protocol.messages import encode_message
from daq.protocol.reports import Stream
from daq.protocol.stream import StreamAssembler

FRAMES = 40_000
BATCH = 25
TICK_HZ = 2500
READS = (166, 4096, 16_384, 65_536)
REPEATS = 5


def _channel(name: str, kind: CountType) -> Channel:
    return Channel(name=name, column=name, unit="1", type=kind, scale=1.0, offset=0.0)


def build_dictionary() -> Dictionary:
    """Return a dictionary with the default layout alone."""
    channels = (
        _channel("current_ref", CountType.I16),
        _channel("current", CountType.I16),
        _channel("position", CountType.U16),
    )
    layout = Layout(id=LayoutId.CONTROL, name="control", channels=tuple(channel.name for channel in channels))
    return Dictionary(
        device="benchmark",
        firmware="1",
        parameters=(),
        channels=channels,
        layouts=(layout,),
        faults=(),
        generators=(),
    )


def build_wire() -> bytes:
    """Return the octets of a stream: noisy currents, so that COBS and CRC see ordinary data."""
    rng = np.random.default_rng(20_240_501)
    words = rng.normal(0.0, 2000.0, (FRAMES, 3 * BATCH)).astype("<i2")
    return b"".join(
        encode_frame(
            encode_message(
                i & 0xFF,
                Stream(
                    layout=LayoutId.CONTROL, batch=BATCH, tick0=i * BATCH, status=2, samples=row.tobytes()
                ),
            )
        )
        for i, row in enumerate(words)
    )


def time_decoding(wire: bytes, read_octets: int, dictionary: Dictionary) -> float:
    """Return the least time to decode `wire` in reads of `read_octets`, s.

    Raises:
        RuntimeError: Samples were lost on the way.
    """
    best = float("inf")
    for _ in range(REPEATS):
        decoder, assembler = FrameDecoder(), StreamAssembler(dictionary)
        start = time.perf_counter()
        for at in range(0, len(wire), read_octets):
            assembler.feed(decoder.feed(wire[at : at + read_octets]))
        best = min(best, time.perf_counter() - start)
        if assembler.counters.samples != FRAMES * BATCH:
            raise RuntimeError(f"{assembler.counters.samples} samples decoded of {FRAMES * BATCH}")
    return best


def main() -> None:
    """Print the tables."""
    dictionary, wire = build_dictionary(), build_wire()
    print(f"{FRAMES} frames of {BATCH} samples of 3 words, best of {REPEATS}")
    print("octets a read   us/frame   million samples/s   MB/s")
    for read_octets in READS:
        seconds = time_decoding(wire, read_octets, dictionary)
        rate = FRAMES * BATCH / seconds / 1e6
        print(
            f"{read_octets:13d} {seconds / FRAMES * 1e6:10.2f} {rate:19.1f} {len(wire) / seconds / 1e6:6.0f}"
        )
    octets = len(wire) / FRAMES
    print(f"octets a frame: {octets:.0f} measured, {wire_octets(3, BATCH)} by the budget")
    print(f"efficiency: {6 * BATCH / octets:.1%} measured, {wire_efficiency(3, BATCH):.1%} by the budget")
    for baud in (115_200, 937_500):
        print(f"line use at {baud} Bd and {TICK_HZ} samples/s: {line_use(baud, 3, BATCH, 1, TICK_HZ):.1%}")


if __name__ == "__main__":
    main()
