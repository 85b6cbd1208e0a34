"""What a viewer of live data may ask for."""

from typing import Annotated

from pydantic import Field

from server.api.schemas.base import Answer, Request
from server.services.viewing.view import LiveOptions

MAX_COLUMNS = 32


class LiveRequest(Request):
    """Columns and rates; as the address's query, and as a text message while it runs."""

    columns: Annotated[list[Annotated[str, Field(max_length=80)]], Field(max_length=MAX_COLUMNS)] = Field(
        default=[], description="Columns in this order; the usual ones by default."
    )
    rate_hz: Annotated[float, Field(gt=0)] | None = Field(
        default=None,
        description="Rows per second, least and greatest value of each; every sample by default.",
    )
    interval_ms: Annotated[int, Field(ge=0, le=5000)] = Field(
        default=50, description="A frame at most so often, ms; 0 sends at once what comes."
    )

    def options(self) -> LiveOptions:
        """Return it as the service takes it."""
        return LiveOptions(columns=tuple(self.columns), rate_hz=self.rate_hz, interval_ms=self.interval_ms)


class TicketAnswer(Answer):
    """A ticket for one WebSocket."""

    ticket: str = Field(
        description="Offer the subprotocols `jointscope.v1` and `ticket.` with this behind it."
    )
    expires_in_s: float = Field(examples=[30.0])
