"""Server-sent events to records, line by line; no I/O here."""

import json

from jointscope_client.records import Event, read_event


class EventParser:
    """Puts the lines of a stream together."""

    def __init__(self) -> None:
        self._kind, self._data = "", list[str]()

    def feed(self, line: str) -> Event | None:
        """Take a line without its end; an empty one ends an event. What was lost comes as kind `lost`."""
        if not line:
            kind, data = self._kind, "\n".join(self._data)
            self._kind, self._data = "", []
            if not data:
                return None
            content = json.loads(data)
            return _lost(content) if kind == "lost" else read_event(content)
        name, _, value = line.partition(":")
        if name == "event":
            self._kind = value.strip()
        elif name == "data":
            self._data.append(value.removeprefix(" "))
        return None


def _lost(content: dict[str, int]) -> Event:
    at = "1970-01-01T00:00:00+00:00"
    text = f"{content['lost']} events were lost by reading too slowly"
    return read_event({"id": 0, "at": at, "rig_id": "", "kind": "lost", "text": text, "data": content})
