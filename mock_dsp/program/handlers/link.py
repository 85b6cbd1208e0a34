"""HELLO, DICT_READ, PING, LINK_STATS, SET_BAUD, EVENT_ACK."""

from daq.protocol.codes import StatusCode
from daq.protocol.commands import DictRead, EventAck, Hello, LinkStats, Ping, SetBaud
from daq.protocol.framing import MAX_BODY_OCTETS
from daq.protocol.message import MAX_DATA_OCTETS
from daq.protocol.replies import (
    DictReadReply,
    EventAckReply,
    HelloReply,
    LinkStatsReply,
    PingReply,
    SetBaudReply,
)
from mock_dsp.program.baud import BAUDS
from mock_dsp.program.refusal import RefusedError
from mock_dsp.program.state import TICK_HZ, ControllerState

ISR_IDLE_US = 21
ISR_POWERED_US = 88
"""Modelled length of the PWM interrupt: sampling and limits; and with field-oriented control on top."""


def hello(state: ControllerState, command: Hello) -> HelloReply:
    """Tell who is here; without a common version only that is refused, so that the host can name both."""
    identity = state.identity
    common = command.proto_min <= identity.version <= command.proto_max
    return HelloReply(
        status=StatusCode.OK if common else StatusCode.UNSUPPORTED_VERSION,
        version=identity.version,
        cookie=command.cookie,
        dictionary_crc=identity.dictionary_crc,
        dictionary_octets=len(identity.dictionary),
        tick_hz=TICK_HZ,
        pwm_hz=TICK_HZ,
        session=identity.session,
        serial_number=identity.serial_number,
        firmware=identity.firmware,
        rx_credits=state.link.rx_credits,
        max_frame=MAX_BODY_OCTETS,
        bauds=BAUDS,
    )


def read_dictionary(state: ControllerState, command: DictRead) -> DictReadReply:
    """Serve a piece of the dictionary; behind its end there is nothing."""
    if command.count > MAX_DATA_OCTETS or command.count % 2:
        raise RefusedError(StatusCode.OUT_OF_RANGE)
    octets = state.identity.dictionary
    if command.offset > len(octets):
        raise RefusedError(StatusCode.OUT_OF_RANGE)
    return DictReadReply(
        status=StatusCode.OK,
        offset=command.offset,
        total=len(octets),
        data=octets[command.offset : command.offset + command.count],
    )


def ping(state: ControllerState, command: Ping) -> PingReply:
    """Tell the time, and take the ping as proof of the baud rate."""
    state.baud.confirm()
    return PingReply(status=StatusCode.OK, cookie=command.cookie, tick=state.tick, subtick=0)


def report_link(state: ControllerState, command: LinkStats) -> LinkStatsReply:
    """Tell the link's counters."""
    link, line, frames = state.link, state.line, state.link.decoder.counters
    return LinkStatsReply(
        status=StatusCode.OK,
        rx_frames=frames.frames,
        rx_crc_errors=frames.crc_errors,
        rx_malformed=frames.malformed + frames.oversize + link.counters.rx_malformed,
        rx_overruns=line.rx_overruns + link.counters.rx_overruns,
        rx_unknown=link.counters.rx_unknown,
        tx_frames=link.counters.tx_frames - line.tx_drops,
        tx_octets=link.counters.tx_octets - line.tx_dropped_octets,
        tx_drops=line.tx_drops,
        isr_max_us=isr_max_us(state),
    )


def set_baud(state: ControllerState, command: SetBaud) -> SetBaudReply:
    """Change the rate after this reply."""
    status = state.baud.request(command.baud, state.time)
    if status is not StatusCode.OK:
        raise RefusedError(status)
    return SetBaudReply(status=StatusCode.OK, baud=command.baud)


def acknowledge_event(state: ControllerState, command: EventAck) -> EventAckReply:
    """Stop repeating an event."""
    state.events.acknowledge(command.event)
    return EventAckReply(status=StatusCode.OK, event=command.event)


def isr_max_us(state: ControllerState) -> int:
    """Return the longest PWM interrupt since boot."""
    return ISR_POWERED_US if state.drive.was_powered else ISR_IDLE_US
