"""How many samples a second the driver takes from a pseudo-terminal: read, journal, decode, hand over as blocks.

    python benchmarks/driver_ceiling.py [SECONDS_OF_STREAM]

A second process writes prebuilt stream frames (25 samples of 3 channels, 166 octets on the wire) into the
pseudo-terminal as fast as it takes them. Everything on the host's side is the real thing, the journal on disk included;
only the introduction of the controller is made up, because the sender understands nothing.
"""

import multiprocessing
import os
import resource
import sys
import tempfile
import time
import tty
from pathlib import Path

import numpy as np

from daq.driver.conversation import Conversation
from daq.driver.handshake import Connection, Handshake
from daq.driver.options import RigOptions
from daq.driver.port_thread import PortThread
from daq.driver.rig import Rig
from daq.driver.sink import SinkTap
from daq.protocol.codes import LayoutId, StatusCode
from daq.protocol.dictionary import Dictionary, build_dictionary
from daq.protocol.dictionary_entries import Channel, CountType, Layout
from daq.protocol.framing import encode_frame
from daq.protocol.messages import encode_message
from daq.protocol.replies import HelloReply
from daq.protocol.reports import Stream
from daq.protocol.round_trip import LinkOptions
from daq.recording.header import make_header
from daq.recording.journal import Journal
from daq.transport.serial_port import SerialTransport

TICK_HZ = 2500
BATCH = 25
CHANNELS = ("current_ref", "current", "position")
DICTIONARY = Dictionary(
    device="benchmark",
    firmware="0",
    parameters=(),
    channels=tuple(
        Channel(name=name, column=name, unit="1", type=CountType.I16, scale=1.0, offset=0.0)
        for name in CHANNELS
    ),
    layouts=(Layout(id=LayoutId.CONTROL, name="control", channels=CHANNELS),),
    faults=(),
    generators=(),
)


def build_frames(frames: int) -> bytes:
    """Return the octets of `frames` stream frames with noise for samples."""
    noise = np.random.default_rng(1).integers(-300, 300, (frames, BATCH * len(CHANNELS)), dtype=np.int16)
    return b"".join(
        encode_frame(
            encode_message(
                k & 0xFF,
                Stream(
                    layout=LayoutId.CONTROL,
                    batch=BATCH,
                    tick0=k * BATCH,
                    status=0,
                    samples=noise[k].tobytes(),
                ),
            )
        )
        for k in range(frames)
    )


def send(descriptor: int, octets: bytes) -> None:
    """Write all octets into the pseudo-terminal; runs in a process of its own."""
    view = memoryview(octets)
    while view:
        view = view[os.write(descriptor, view[:65536]) :]


def open_unintroduced(path: str) -> Rig:
    """Return a rig on a port whose other end understands nothing."""
    options = RigOptions(link=LinkOptions(tries=1, rto_initial_ns=10**9))
    octets = build_dictionary(DICTIONARY)
    hello = HelloReply(
        status=StatusCode.OK, version=1, cookie=0, dictionary_crc=0, dictionary_octets=len(octets),
        tick_hz=TICK_HZ, pwm_hz=TICK_HZ, session=1, serial_number=0, firmware=0, rx_credits=512, max_frame=254,
        bauds=(),
    )  # fmt: skip
    transport = SerialTransport(path, 115_200)
    conversation = Conversation(transport, options.link, SinkTap(), time.monotonic_ns)
    connection = Connection(
        conversation=conversation, hello=hello, dictionary=DICTIONARY, dictionary_octets=octets, baud=115_200
    )
    handshake = Handshake(lambda baud: SerialTransport(path, baud), path, options, time.monotonic_ns)
    port = PortThread(connection, handshake, options, time.monotonic_ns)
    port.start()
    return Rig(port, options)


def main() -> None:
    """Measure once and print the figures."""
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 1001.0
    frames = round(seconds * TICK_HZ / BATCH)
    octets = build_frames(frames)
    master, slave = os.openpty()
    tty.setraw(slave)
    with tempfile.TemporaryDirectory() as folder, open_unintroduced(os.ttyname(slave)) as rig:
        header = make_header(dictionary=rig.dictionary_octets, tick_hz=TICK_HZ, divisor=1)
        journal = Journal.create(Path(folder) / "ceiling.journal", header)
        rig.attach(journal)
        sender = multiprocessing.get_context("fork").Process(target=send, args=(master, octets))
        before = resource.getrusage(resource.RUSAGE_SELF)
        started_s = time.perf_counter()
        sender.start()
        samples = lost = blocks = 0
        while samples + lost < frames * BATCH:
            for block in rig.next_blocks(1.0):
                samples += block.ticks.size
                lost += sum(gap.missing_samples for gap in block.gaps)
                blocks += 1
        elapsed_s = time.perf_counter() - started_s
        after = resource.getrusage(resource.RUSAGE_SELF)
        sender.join()
        rig.detach()
        journal.close("done")
        cpu_s = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        print(f"samples            {samples} received, {lost} lost, in {blocks} blocks")
        print(f"journal            {journal.octets} octets")
        print(f"elapsed            {elapsed_s:.2f} s, CPU of this process {cpu_s:.2f} s")
        print(f"ceiling            {samples / elapsed_s / 1e6:.2f} million samples/s (wanted: 2)")
        print(
            f"CPU per sample     {cpu_s / samples * 1e9:.0f} ns = {cpu_s / samples * TICK_HZ:.2%} of a core at 1x"
        )
    os.close(slave)
    os.close(master)


if __name__ == "__main__":
    main()
