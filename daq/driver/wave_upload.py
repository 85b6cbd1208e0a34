"""Upload of a table of currents into one of the controller's slots."""

import zlib

from daq.driver.parameters import Ask
from daq.excitation.spec import Table
from daq.excitation.waveform import to_words
from daq.protocol.commands import WaveBegin, WaveCommit, WaveData

CHUNK_WORDS = 96


def upload_table(table: Table, ask: Ask) -> None:
    """Send the table's words and have the controller check them.

    Raises:
        ValueError: A value does not fit a word.
        DeviceRefusedError: The controller refused, for example because the slot is being played.
    """
    octets = to_words(table.values_a).astype("<i2").tobytes()
    length = len(table.values_a)
    detail = f"table of {length} words in slot {table.slot}"
    ask(WaveBegin(slot=table.slot, length=length, crc=zlib.crc32(octets)), detail)
    for first in range(0, length, CHUNK_WORDS):
        words = octets[2 * first : 2 * (first + CHUNK_WORDS)]
        ask(WaveData(slot=table.slot, offset=first, words=words), detail)
    ask(WaveCommit(slot=table.slot), detail)
