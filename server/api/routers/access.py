"""Tokens and the audit log; admins only, but for asking whose token this is."""

from typing import Annotated

from fastapi import APIRouter, Path, Query

from server.api.dependencies import AdminDep, ReadDep, ServicesDep
from server.api.schemas.access import (
    AuditAnswer,
    AuditPage,
    TokenAnswer,
    TokenBody,
    TokenList,
    TokenMade,
    WhoAnswer,
)

router = APIRouter(tags=["access"])
MAX_ID = 2**63 - 1


@router.get("/tokens")
def list_tokens(services: ServicesDep, who: AdminDep) -> TokenList:
    """List all tokens, newest first, revoked ones included."""
    return TokenList(items=[TokenAnswer.model_validate(token) for token in services.tokens.list()])


@router.post("/tokens", status_code=201)
def create_token(body: TokenBody, services: ServicesDep, who: AdminDep) -> TokenMade:
    """Make a token; its secret is shown in this answer and never again."""
    scopes = [scope.value for scope in body.scopes]
    with services.audit.record(who, "token.create", "tokens", name=body.name, scopes=scopes) as details:
        made = services.tokens.create(body.name, tuple(body.scopes), body.expires_in_s)
        details["id"] = made.info.id
    return TokenMade(secret=made.secret, token=TokenAnswer.model_validate(made.info))


@router.get("/tokens/me")
def read_own_token(who: ReadDep) -> WhoAnswer:
    """Tell whose token this is and what it may do."""
    return WhoAnswer(token_id=who.token_id, name=who.name, scopes=sorted(who.scopes))


@router.delete("/tokens/{token_id}")
def revoke_token(
    token_id: Annotated[str, Path(description="First 8 characters of the token behind `js_`.")],
    services: ServicesDep,
    who: AdminDep,
) -> TokenAnswer:
    """Make a token useless from now on."""
    with services.audit.record(who, "token.revoke", f"tokens/{token_id}"[:200]):
        return TokenAnswer.model_validate(services.tokens.revoke(token_id))


@router.get("/audit")
def list_audit(
    services: ServicesDep,
    who: AdminDep,
    resource: Annotated[str | None, Query(max_length=200, examples=["rigs/emulated"])] = None,
    before: Annotated[int | None, Query(ge=1, le=MAX_ID, description="Only numbers below this.")] = None,
    limit: Annotated[int, Query(ge=1, le=500)] = 100,
) -> AuditPage:
    """List who moved or changed what, newest first."""
    entries = services.audit.page(resource=resource, before=before, limit=limit)
    following = entries[-1].id if len(entries) == limit else None
    return AuditPage(items=[AuditAnswer.model_validate(each) for each in entries], next_before=following)
