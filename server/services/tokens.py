"""Access tokens: 256 random bits, shown once, kept only as a hash; and what each scope allows.

A random token needs no slow hash: nobody guesses 256 bits. The first characters are the token's id, so that it can
be listed and revoked without being known.
"""

import hashlib
import secrets
import threading
import time
from dataclasses import dataclass
from datetime import datetime, timedelta
from enum import StrEnum

import sqlalchemy as sa

from server.services.errors import InvalidValueError, NotFoundError
from server.storage.database import Database
from server.storage.tables import TokenRow
from server.storage.types import utc_now

PREFIX = "js_"
_ID_CHARACTERS = 8
_CACHE_S = 2.0


class Scope(StrEnum):
    """What a token may do; a higher scope contains the lower ones."""

    READ = "read"
    RUN = "run"
    ARM = "arm"
    ADMIN = "admin"


_ORDER = tuple(Scope)


@dataclass(frozen=True, slots=True, kw_only=True)
class Principal:
    """Who asks: a token's id and name, and its scopes, implied ones included."""

    token_id: str
    name: str
    scopes: frozenset[Scope]

    def may(self, scope: Scope) -> bool:
        """Tell whether the scope is allowed."""
        return scope in self.scopes


@dataclass(frozen=True, slots=True, kw_only=True)
class TokenInfo:
    """A token as it is listed: everything but the secret."""

    id: str
    name: str
    scopes: tuple[Scope, ...]
    created_at: datetime
    expires_at: datetime | None
    revoked_at: datetime | None


@dataclass(frozen=True, slots=True, kw_only=True)
class NewToken:
    """A token just made; `secret` is not kept anywhere."""

    secret: str
    info: TokenInfo


class TokenService:
    """Makes, finds and revokes tokens.

    Args:
        database: where hashes are kept.
    """

    def __init__(self, database: Database) -> None:
        self._database = database
        self._cache: dict[str, tuple[float, Principal | None]] = {}
        self._lock = threading.Lock()

    def create(self, name: str, scopes: tuple[Scope, ...], expires_in_s: float | None = None) -> NewToken:
        """Make a token and return its secret, which cannot be read again.

        Raises:
            InvalidValueError: no name, no scope.
        """
        if not name.strip() or len(name) > 120:
            raise InvalidValueError(
                "a token's name must have 1..120 characters",
                field="name",
                value=name,
                remedy="name who uses it, so that the audit log can",
            )
        if not scopes:
            raise InvalidValueError(
                "a token needs a scope",
                field="scopes",
                value="",
                remedy=f"give one or more of {', '.join(Scope)}",
            )
        secret = PREFIX + secrets.token_urlsafe(32)
        expires_at = None if expires_in_s is None else utc_now() + timedelta(seconds=expires_in_s)
        row = TokenRow(
            id=secret[len(PREFIX) :][:_ID_CHARACTERS],
            name=name,
            sha256=_hash(secret),
            scopes=[scope.value for scope in _ORDER if scope in scopes],
            created_at=utc_now(),
            expires_at=expires_at,
        )
        with self._database.write() as session:
            session.add(row)
        return NewToken(secret=secret, info=_info(row))

    def list(self) -> list[TokenInfo]:
        """Return all tokens, newest first, revoked ones included."""
        with self._database.read() as session:
            rows = session.scalars(sa.select(TokenRow).order_by(TokenRow.created_at.desc()))
            return [_info(row) for row in rows]

    def is_valid(self, token_id: str) -> bool:
        """Tell whether the token with this id can be used now."""
        with self._database.read() as session:
            row = session.get(TokenRow, token_id)
        if row is None or row.revoked_at is not None:
            return False
        return row.expires_at is None or row.expires_at > utc_now()

    def any_valid(self) -> bool:
        """Tell whether any token can be used now."""
        now = utc_now()
        return any(
            token.revoked_at is None and (token.expires_at is None or token.expires_at > now)
            for token in self.list()
        )

    def revoke(self, token_id: str) -> TokenInfo:
        """Make a token useless from now on; a running service in another process notices within two seconds.

        Raises:
            NotFoundError: no such token.
        """
        with self._database.write() as session:
            row = session.get(TokenRow, token_id)
            if row is None:
                raise NotFoundError("token", token_id, "list the tokens; its id is the first 8 characters")
            row.revoked_at = row.revoked_at or utc_now()
            info = _info(row)
        with self._lock:
            self._cache.clear()
        return info

    def recall(self, secret: str) -> Principal | None:
        """Return who a secret belongs to if that was looked up within the last two seconds; never waits."""
        kept = self._cache.get(_hash(secret))
        return kept[1] if kept is not None and time.monotonic() - kept[0] < _CACHE_S else None

    def find(self, secret: str) -> Principal | None:
        """Return who a secret belongs to; None for an unknown, expired or revoked one."""
        digest, now_s = _hash(secret), time.monotonic()
        with self._lock:
            kept = self._cache.get(digest)
        if kept is not None and now_s - kept[0] < _CACHE_S:
            return kept[1]
        principal = self._look_up(digest)
        if principal is not None:  # wrong secrets are not kept: they would fill the memory
            with self._lock:
                self._cache[digest] = (now_s, principal)
        return principal

    def still_valid(self, token_id: str) -> bool:
        """Tell whether the token that somebody came with may still be used; for connections that last."""
        with self._database.read() as session:
            row = session.get(TokenRow, token_id)
        if row is None or row.revoked_at is not None:
            return False
        return row.expires_at is None or row.expires_at > utc_now()

    def _look_up(self, digest: str) -> Principal | None:
        with self._database.read() as session:
            row = session.scalar(sa.select(TokenRow).where(TokenRow.sha256 == digest))
        if row is None or row.revoked_at is not None:
            return None
        if row.expires_at is not None and row.expires_at <= utc_now():
            return None
        return Principal(token_id=row.id, name=row.name, scopes=implied_scopes(_scopes(row)))


def implied_scopes(scopes: tuple[Scope, ...]) -> frozenset[Scope]:
    """Return the scopes with all that they contain."""
    highest = max((_ORDER.index(scope) for scope in scopes), default=-1)
    return frozenset(_ORDER[: highest + 1])


def _hash(secret: str) -> str:
    return hashlib.sha256(secret.encode()).hexdigest()


def _scopes(row: TokenRow) -> tuple[Scope, ...]:
    return tuple(Scope(scope) for scope in row.scopes)


def _info(row: TokenRow) -> TokenInfo:
    return TokenInfo(
        id=row.id,
        name=row.name,
        scopes=_scopes(row),
        created_at=row.created_at,
        expires_at=row.expires_at,
        revoked_at=row.revoked_at,
    )
