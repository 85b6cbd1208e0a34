"""Tokens and the audit log as JSON."""

from datetime import datetime
from typing import Annotated, Any

from pydantic import Field

from server.api.schemas.base import Answer, Request
from server.services.tokens import Scope


class TokenBody(Request):
    """A token to make."""

    name: Annotated[str, Field(min_length=1, max_length=120)] = Field(
        description="Who uses it.", examples=["bench 2"]
    )
    scopes: Annotated[list[Scope], Field(min_length=1)] = Field(examples=[["read", "run"]])
    expires_in_s: Annotated[float, Field(gt=0, le=10 * 366 * 86400)] | None = None


class TokenAnswer(Answer):
    """A token without its secret."""

    id: str
    name: str
    scopes: list[Scope]
    created_at: datetime
    expires_at: datetime | None
    revoked_at: datetime | None


class TokenList(Answer):
    """All tokens, newest first."""

    items: list[TokenAnswer]


class TokenMade(Answer):
    """A token just made; the secret is shown this once."""

    secret: str
    token: TokenAnswer


class WhoAnswer(Answer):
    """Whose token this is."""

    token_id: str
    name: str
    scopes: list[Scope] = Field(description="With all that they contain.")


class AuditAnswer(Answer):
    """One line of the audit log."""

    id: int
    at: datetime
    token_id: str
    token_name: str
    action: str = Field(examples=["rig.connect"])
    resource: str = Field(examples=["rigs/emulated"])
    outcome: str = Field(examples=["done"])
    details: dict[str, Any]  # JSON values


class AuditPage(Answer):
    """Newest lines first; `next_before` continues, null at the end."""

    items: list[AuditAnswer]
    next_before: int | None
