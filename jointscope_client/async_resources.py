"""The same as `resources.py` for asyncio: rigs, recordings, models."""

from collections.abc import AsyncIterator, Sequence
from pathlib import Path
from typing import Any, Protocol, TypeVar

from jointscope_client import calls, records
from jointscope_client.calls import get, many, one, path_of, post
from jointscope_client.samples import Samples

T = TypeVar("T")


class Performer(Protocol):
    """What sends calls: `AsyncClient`."""

    async def perform(self, call: calls.Call[T]) -> T:
        """Send one call."""
        ...

    def pages(self, call: calls.Call[calls.Page[T]]) -> AsyncIterator[T]:
        """Give all items of a list."""
        ...

    async def download(self, call: calls.Call[None], target: Path) -> Path:
        """Write an answer's body to a file."""
        ...


class Rigs:
    """Rigs: connection, state, parameters, stop. What moves one is done through its lease."""

    def __init__(self, client: Performer) -> None:
        self._client = client

    async def all(self) -> list[records.Rig]:
        """Return all rigs."""
        return await self._client.perform(get(path_of("rigs"), many(records.read_rig)))

    async def get(self, rig_id: str) -> records.Rig:
        """Return a rig's state."""
        return await self._client.perform(get(path_of("rigs", rig_id), one(records.read_rig)))

    async def connect(self, rig_id: str) -> records.Rig:
        """Open the rig's port; its drive stays off."""
        return await self._client.perform(post(path_of("rigs", rig_id, "connect"), one(records.read_rig)))

    async def disconnect(self, rig_id: str) -> records.Rig:
        """Give the rig's port back."""
        return await self._client.perform(post(path_of("rigs", rig_id, "disconnect"), one(records.read_rig)))

    async def estop(self, rig_id: str) -> records.Rig:
        """Switch the drive off at once; no lease is needed. Beside a wired emergency stop, never instead of one."""
        return await self._client.perform(post(path_of("rigs", rig_id, "estop"), one(records.read_rig)))

    async def parameters(self, rig_id: str) -> list[records.Parameter]:
        """Read all parameters from the controller."""
        return await self._client.perform(
            get(path_of("rigs", rig_id, "parameters"), many(records.read_parameter))
        )

    async def link(self, rig_id: str) -> dict[str, Any]:  # JSON values
        """Tell how the link is doing."""
        found: dict[str, Any] = await self._client.perform(
            get(path_of("rigs", rig_id, "link"), calls.as_json)
        )
        return found


class Recordings:
    """Recordings: list, samples, upload, download, deletion."""

    def __init__(self, client: Performer) -> None:
        self._client = client

    def all(self, **filters: Any) -> AsyncIterator[records.RecordingInfo]:  # text, numbers, times
        """Give recordings, newest first.

        Filters: rig, session, campaign, origin, since, until, column, text, deleted; `limit` is the size of a page.
        """
        return self._client.pages(calls.listing("recordings", records.read_recording, filters))

    async def get(self, recording_id: str) -> records.RecordingInfo:
        """Return what is known of a recording."""
        return await self._client.perform(
            get(path_of("recordings", recording_id), one(records.read_recording))
        )

    async def samples(
        self,
        recording_id: str,
        columns: Sequence[str] = (),
        *,
        span_s: tuple[float | None, float | None] = (None, None),
        every: int = 1,
        points: int | None = None,
    ) -> Samples:
        """Read samples as numpy arrays, all digits kept.

        Args:
            recording_id: the recording.
            columns: only these; none takes all.
            span_s: from the first time on, up to the second, which is left out; None is open.
            every: every so manieth sample, unfiltered.
            points: instead, minimum and maximum over so many pieces, to draw.
        """
        params = {"column": list(columns), "start_s": span_s[0], "stop_s": span_s[1]}
        params |= {"every": every, "points": points}
        return await self._client.perform(calls.samples(recording_id, params))

    async def upload(
        self,
        path: Path,
        *,
        name: str | None = None,
        mappings: Sequence[str] = (),
        leave_out: Sequence[str] = (),
    ) -> records.RecordingInfo:
        """Upload a measured file: CSV, CSV.gz, Parquet, MAT, HDF5.

        Args:
            path: the file.
            name: of the recording; None takes the file's.
            mappings: `NEW=OLD`, `NEW=OLD*FACTOR` or `NEW=OLD[UNIT]`.
            leave_out: columns not to take.
        """
        return await self._client.perform(calls.upload(path, name, mappings, leave_out))

    async def download(self, recording_id: str, target: Path, file_format: str = "parquet") -> Path:
        """Download a recording as parquet, csv, mat, hdf5, mdf4, mcap, or `stored`, as the service keeps it."""
        path = path_of("recordings", recording_id, "file")
        return await self._client.download(get(path, calls.nothing, {"format": file_format}), target)

    async def delete(self, recording_id: str) -> records.RecordingInfo:
        """Delete a recording; it can be taken back for some weeks."""
        path = path_of("recordings", recording_id)
        return await self._client.perform(
            calls.Call(method="DELETE", path=path, read=one(records.read_recording))
        )

    async def undelete(self, recording_id: str) -> records.RecordingInfo:
        """Take a deletion back."""
        path = path_of("recordings", recording_id, "undelete")
        return await self._client.perform(post(path, one(records.read_recording)))


class Models:
    """Joint models and their versions."""

    def __init__(self, client: Performer) -> None:
        self._client = client

    def all(self, **filters: Any) -> AsyncIterator[records.Model]:  # text and numbers
        """Give model versions, newest first. Filters: name, source."""
        return self._client.pages(calls.listing("models", records.read_model, filters))

    async def get(self, model_id: str) -> records.Model:
        """Return one version."""
        return await self._client.perform(get(path_of("models", model_id), one(records.read_model)))

    async def add(self, text: str, *, note: str = "", parent: str | None = None) -> records.Model:
        """Add a version from a model file's text."""
        return await self._client.perform(calls.add_model(text, note, parent))

    async def file(self, model_id: str) -> str:
        """Return one version as a model file."""
        return await self._client.perform(get(path_of("models", model_id, "file"), calls.as_text))
