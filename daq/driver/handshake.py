"""Opening a controller: find its rate, agree on a protocol version, get its dictionary, go to the working rate."""

import zlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

from daq.driver.conversation import Clock, Conversation
from daq.driver.dictionary_cache import DictionaryCache
from daq.driver.options import RigOptions
from daq.driver.sink import SinkTap
from daq.errors import DeviceRefusedError, DictionaryError, LinkTimeoutError, PortError, ProtocolVersionError
from daq.protocol.codes import PROTOCOL_VERSION, StatusCode
from daq.protocol.commands import DictRead, Hello, Ping, SetBaud
from daq.protocol.dictionary import MAX_DICTIONARY_OCTETS, Dictionary, parse_dictionary
from daq.protocol.message import Reply
from daq.protocol.replies import DictReadReply, HelloReply
from daq.transport.interface import Transport

_DICT_OCTETS = 192
_REVERT_TRIES = 4
"""PINGs until a controller must have gone back to its old rate: it does so 500 ms after SET_BAUD."""
Opener = Callable[[int], Transport]
R = TypeVar("R", bound=Reply)


@dataclass(frozen=True, slots=True, kw_only=True)
class Connection:
    """A controller that has introduced itself.

    Attributes:
        conversation: The open port.
        hello: What it said of itself.
        dictionary: Its dictionary, parsed.
        dictionary_octets: The same as served, for the journal's header.
        baud: Rate in use.
        warnings: What did not go as wished, in words.
    """

    conversation: Conversation
    hello: HelloReply
    dictionary: Dictionary
    dictionary_octets: bytes
    baud: int
    warnings: tuple[str, ...] = ()


class Handshake:
    """The steps from an opener to a `Connection`; usable again after the port was lost.

    Args:
        opener: Opens the port at a rate.
        name: The port's URL, for messages.
        options: How to reach the controller.
        clock_ns: Host monotonic clock, ns.
    """

    def __init__(self, opener: Opener, name: str, options: RigOptions, clock_ns: Clock) -> None:
        self._opener = opener
        self._name = name
        self._options = options
        self._clock_ns = clock_ns
        self._cache = DictionaryCache(options.cache_dir)

    def connect(self, first_baud: int, tap: SinkTap) -> Connection:
        """Open the port and go through all steps.

        Args:
            first_baud: Rate to try first.
            tap: Where received octets go, from the first one on.

        Raises:
            PortError: No port, or nobody understandable at any rate.
            ProtocolVersionError: The controller speaks no version of ours.
            DictionaryError: Its dictionary is not what HELLO announced.
        """
        transport = self._opener(first_baud)
        try:
            conversation, hello, baud = self._find(transport, first_baud, tap)
            octets = self._read_dictionary(conversation, hello)
            dictionary = parse_dictionary(octets)
            baud, warnings = self._change_baud(conversation, hello, baud)
        except BaseException:
            transport.close()
            raise
        return Connection(
            conversation=conversation, hello=hello, dictionary=dictionary, dictionary_octets=octets,
            baud=baud, warnings=warnings,
        )  # fmt: skip

    def _find(
        self, transport: Transport, first_baud: int, tap: SinkTap
    ) -> tuple[Conversation, HelloReply, int]:
        """Say HELLO at each rate until somebody answers."""
        rates = [first_baud]
        if transport.has_rate:
            rates = list(dict.fromkeys((first_baud, self._options.start_baud, self._options.baud)))
        heard = []
        for baud in rates:
            transport.change_baud(baud)
            conversation = Conversation(transport, self._options.link, tap, self._clock_ns)
            try:
                return conversation, self._say_hello(conversation), baud
            except LinkTimeoutError:
                heard.append((baud, conversation.link.decoder.counters.octets))
        raise PortError(_explain_silence(self._name, heard))

    def _say_hello(self, conversation: Conversation) -> HelloReply:
        cookie = self._clock_ns() & 0xFFFFFFFF
        command = Hello(proto_min=PROTOCOL_VERSION, proto_max=PROTOCOL_VERSION, cookie=cookie)
        try:
            reply = conversation.ask(command)
        except DeviceRefusedError as refusal:
            if refusal.status == StatusCode.UNSUPPORTED_VERSION:
                raise ProtocolVersionError(_explain_version(self._name, None)) from refusal
            raise
        hello = expect(reply, HelloReply)
        if hello.version != PROTOCOL_VERSION:
            raise ProtocolVersionError(_explain_version(self._name, hello.version))
        if hello.cookie != cookie:
            raise PortError(
                f"{self._name}: the reply to HELLO was meant for another host; is the port shared?"
            )
        return hello

    def _read_dictionary(self, conversation: Conversation, hello: HelloReply) -> bytes:
        cached = self._cache.load(hello.dictionary_crc)
        if cached is not None:
            return cached
        octets = b""
        while len(octets) < min(hello.dictionary_octets, MAX_DICTIONARY_OCTETS):
            # The last count is rounded up to an even one, as the protocol demands.
            left = hello.dictionary_octets - len(octets)
            count = min(_DICT_OCTETS, left + left % 2)
            part = expect(conversation.ask(DictRead(offset=len(octets), count=count)), DictReadReply)
            if not part.data:
                break
            octets += part.data
        crc = zlib.crc32(octets)
        if crc != hello.dictionary_crc or len(octets) != hello.dictionary_octets:
            raise DictionaryError(
                f"{self._name}: dictionary of {len(octets)} octets has the CRC {crc:08x}, HELLO announced "
                f"{hello.dictionary_octets} octets with {hello.dictionary_crc:08x}; units and limits would be wrong, "
                "so nothing is run: restart the controller, or load its program again"
            )
        self._cache.store(octets)
        return octets

    def _change_baud(
        self, conversation: Conversation, hello: HelloReply, baud: int
    ) -> tuple[int, tuple[str, ...]]:
        """Go to the working rate; when the line does not carry it, wait for the old one and stay there."""
        wanted, transport = self._options.baud, conversation.transport
        if wanted == baud or not transport.has_rate:
            return baud, ()
        if wanted not in hello.bauds:
            offered = ", ".join(str(rate) for rate in hello.bauds)
            raise PortError(f"{self._name}: the controller has no {wanted} baud; choose one of {offered}")
        conversation.ask(SetBaud(baud=wanted))
        transport.change_baud(wanted)
        try:
            conversation.ask(Ping(cookie=wanted))
        except LinkTimeoutError:
            transport.change_baud(baud)
            self._await_revert(conversation)
            return baud, (
                f"{self._name}: the line does not carry {wanted} baud, stayed at {baud}; shorten the cable",
            )
        return wanted, ()

    def _await_revert(self, conversation: Conversation) -> None:
        for tries_left in reversed(range(_REVERT_TRIES)):
            try:
                conversation.ask(Ping(cookie=0))
                return
            except LinkTimeoutError:
                if tries_left == 0:
                    raise


def expect(reply: Reply, kind: type[R]) -> R:
    """Return `reply` as the kind that its command always has; the link pairs them, so nothing else can come."""
    if not isinstance(reply, kind):
        raise TypeError(
            f"{type(reply).__name__} came where {kind.__name__} belongs; this is an error in the link"
        )
    return reply


def _explain_silence(name: str, heard: list[tuple[int, int]]) -> str:
    rates = ", ".join(f"{baud} baud ({octets} octets received)" for baud, octets in heard)
    if any(octets for _, octets in heard):
        advice = "octets come in but make no frames: wrong baud? Give the controller's rate, or reset it"
    else:
        advice = "nothing comes in: check the cable and the controller's supply, then the baud rate"
    return f"{name}: no controller answered at {rates}; {advice}; rates to try: {_RATES_TO_TRY}"


_RATES_TO_TRY = "115200, 230400, 460800, 937500, 1171875, 1562500, 2343750, 3125000"


def _explain_version(name: str, version: int | None) -> str:
    theirs = "no version that we know" if version is None else f"version {version}"
    return (
        f"{name}: the controller speaks {theirs} of the protocol, this program version {PROTOCOL_VERSION} only; "
        "update Jointscope if the controller is newer, else the controller's program"
    )
