"""A controller's events in words, as the service stores them."""

from daq.protocol.codes import DriveState, EventCode, FaultBit
from daq.protocol.dictionary import Dictionary
from daq.protocol.reports import Event
from server.services.events import ServiceEvent
from server.services.rigs.views import fault_views, state_name

KINDS = {
    EventCode.BOOT: ("controller.boot", "the controller has started"),
    EventCode.STATE: ("drive.state", "the drive is {}"),
    EventCode.FAULT: ("drive.fault", "the drive tripped: {}"),
    EventCode.LIMIT: ("drive.limit", "a limit is active"),
    EventCode.LEASE_LOST: ("drive.lease_lost", "the drive's lease ran out; it ramps down by itself"),
    EventCode.RUN_STARTED: ("run.started", "the excitation begins"),
    EventCode.RUN_DONE: ("run.done", "the excitation has ended"),
    EventCode.UNDERRUN: ("run.underrun", "set-points came too late; the drive ramps down"),
    EventCode.CAPTURE_READY: ("capture.ready", "the capture buffer is full"),
    EventCode.ESTOP: ("drive.estop", "emergency stop"),
    EventCode.BAUD_REVERTED: ("controller.baud_reverted", "the line did not carry the new rate"),
}


def describe_event(rig_id: str, event: Event, dictionary: Dictionary | None) -> ServiceEvent:
    """Return a controller's event as the service stores it."""
    if event.code not in tuple(EventCode):
        kind, text = "controller.unknown", f"event {event.code}, which this program does not know"
    else:
        kind, text = KINDS[EventCode(event.code)]
    data: dict[str, object] = {"code": event.code, "arg": event.arg}
    if event.code == EventCode.STATE:
        data["state"] = state_name(event.arg)
        text = text.format(data["state"])
    if event.code == EventCode.FAULT:
        data["fault"], words = _fault_words(event.arg, dictionary)
        text = text.format(words)
    return ServiceEvent(rig_id=rig_id, kind=kind, text=text, tick=event.tick, data=data)


def is_resting(state: int) -> bool:
    """Tell whether a drive in this state has no current."""
    return state in (DriveState.IDLE, DriveState.SAFE_TIMEOUT, DriveState.FAULT)


def _fault_words(bit: int, dictionary: Dictionary | None) -> tuple[str, str]:
    if dictionary is not None and 0 <= bit < 16:
        fault = fault_views(1 << bit, dictionary)[0]
        return fault.name, f"{fault.name}: {fault.text} {fault.remedy}"
    name = FaultBit(bit).name.lower() if bit in tuple(FaultBit) else f"bit_{bit}"
    return name, name
