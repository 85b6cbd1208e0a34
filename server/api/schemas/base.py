"""The base of what goes out and comes in as JSON."""

from pydantic import BaseModel, ConfigDict


class Answer(BaseModel):
    """An answer, filled from a service's record of the same field names."""

    model_config = ConfigDict(from_attributes=True)


class Request(BaseModel):
    """A request's body: unknown keys are refused, and so are NaN and infinity.

    Booleans are `StrictBool`: otherwise 0 and "yes" would be taken, which the OpenAPI document does not say.
    """

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)
