"""Joint models and their versions: each with what it came from."""

import uuid
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from enum import StrEnum
from typing import Any

import sqlalchemy as sa
import yaml

from server.services.errors import InvalidValueError, NotFoundError
from server.services.plain_yaml import parse_plain_yaml
from server.storage.database import Database
from server.storage.tables import LineageRow, ModelRow

_REMEDY = "GET /api/v1/models lists those that there are"
_MAX_NAME = 120


class SourceKind(StrEnum):
    """What a model version can come from."""

    MODEL = "model"
    RECORDING = "recording"
    ANALYSIS = "analysis"


@dataclass(frozen=True, slots=True, kw_only=True)
class Source:
    """One thing that a model version came from."""

    kind: SourceKind
    id: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelView:
    """One version of a model.

    Attributes:
        document: the model file's content.
        effects: ids of the effects in it.
        lineage: what it came from.
    """

    id: str
    name: str
    version: int
    note: str
    effects: list[str]
    document: dict[str, Any]  # JSON values
    lineage: list[Source]
    created_by: str
    created_at: datetime


@dataclass(frozen=True, slots=True, kw_only=True)
class NewModel:
    """A version to add; its number follows from those of the same name."""

    document: Mapping[str, Any]  # JSON values
    note: str = ""
    created_by: str = ""
    lineage: tuple[Source, ...] = ()


class ModelStore:
    """Keeps model versions; none is ever changed.

    Args:
        database: where they are kept.
    """

    def __init__(self, database: Database) -> None:
        self._database = database

    def add_text(self, octets: bytes, new: NewModel) -> ModelView:
        """Add a version from the text of a model file; `new.document` is not looked at.

        Raises:
            InvalidValueError: no model; names the field.
        """
        content = parse_plain_yaml(octets)
        return self.add(
            NewModel(document=content, note=new.note, created_by=new.created_by, lineage=new.lineage)
        )

    def add(self, new: NewModel) -> ModelView:
        """Add a version.

        Raises:
            InvalidValueError: the document is no model.
        """
        document = _checked(new.document)
        name = document["name"]
        lineage = dict.fromkeys((source.kind.value, source.id) for source in new.lineage)
        with self._database.write() as session:
            newest = session.scalar(sa.select(sa.func.max(ModelRow.version)).where(ModelRow.name == name))
            row = ModelRow(
                id=str(uuid.uuid4()),
                name=name,
                version=(newest or 0) + 1,
                document={**document, "version": (newest or 0) + 1},
                note=new.note,
                created_by=new.created_by,
                lineage=[LineageRow(kind=kind, source_id=source) for kind, source in lineage],
            )
            session.add(row)
            session.flush()
            return _view(row)

    def get(self, model_id: str) -> ModelView:
        """Return one version.

        Raises:
            NotFoundError: there is none of this id.
        """
        with self._database.read() as session:
            row = session.get(ModelRow, model_id)
            if row is None:
                raise NotFoundError("model", model_id, _REMEDY)
            return _view(row)

    def text(self, model_id: str) -> str:
        """Return one version as a model file.

        Raises:
            NotFoundError: there is none of this id.
        """
        return yaml.safe_dump(self.get(model_id).document, sort_keys=False, allow_unicode=True)

    def page(
        self, *, name: str | None = None, source: str | None = None, offset: int = 0, limit: int = 100
    ) -> list[ModelView]:
        """Return versions, newest first.

        Args:
            name: only of this model.
            source: only what came from the recording, analysis or model of this id.
            offset: leave out so many.
            limit: return at most so many.
        """
        query = sa.select(ModelRow).order_by(
            ModelRow.created_at.desc(), ModelRow.name, ModelRow.version.desc()
        )
        if name is not None:
            query = query.where(ModelRow.name == name)
        if source is not None:
            query = query.where(ModelRow.lineage.any(LineageRow.source_id == source))
        with self._database.read() as session:
            return [_view(row) for row in session.scalars(query.offset(offset).limit(limit))]


def _checked(document: object) -> dict[str, Any]:  # JSON values
    """Return a document as the workflow would write it."""
    from discrepancy.model.reader import model_to_dict, parse_model  # here: it loads the whole catalogue

    try:
        checked = model_to_dict(parse_model(document))
    except (ValueError, TypeError, OverflowError) as error:
        raise _invalid(str(error)) from error
    if not 0 < len(checked["name"]) <= _MAX_NAME:
        raise _invalid(f"name: 1..{_MAX_NAME} characters are allowed")
    return checked


def _invalid(reason: str) -> InvalidValueError:
    field = reason.split(":")[0] if ":" in reason else "body"
    return InvalidValueError(
        reason, field=field, value=None, remedy="see config/models/joint1.yaml for a commented model file"
    )


def _view(row: ModelRow) -> ModelView:
    return ModelView(
        id=row.id,
        name=row.name,
        version=row.version,
        note=row.note,
        effects=[effect["id"] for effect in row.document.get("effects", [])],
        document=row.document,
        lineage=[Source(kind=SourceKind(each.kind), id=each.source_id) for each in row.lineage],
        created_by=row.created_by,
        created_at=row.created_at,
    )
