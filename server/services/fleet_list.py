"""The list of joints of a fleet: a CSV file with the columns joint, model, train, test."""

import csv
import re
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from server.errors import InputError, InputLocation

COLUMNS = ("joint", "model", "train", "test")
_NAME = re.compile(r"\w[\w.-]*")


@dataclass(frozen=True, slots=True, kw_only=True)
class FleetJoint:
    """One line of the list; paths are relative to the list's own folder.

    Attributes:
        joint: names the joint's folder.
        train, test: recordings, several separated by semicolons in the file.
    """

    joint: str
    model: Path
    train: tuple[Path, ...]
    test: tuple[Path, ...]

    @property
    def files(self) -> tuple[Path, ...]:
        """Return everything that is read for this joint."""
        return (self.model, *self.train, *self.test)


def read_fleet_list(path: Path) -> tuple[FleetJoint, ...]:
    """Read the list; files that are not there show later, as that joint's error.

    Raises:
        InputError: no such file, other columns, no line, a joint without a name or one that is there twice.
    """
    if not path.is_file():
        raise InputError("no such fleet list; a CSV file with the columns joint,model,train,test is needed",
                         InputLocation(source=path))  # fmt: skip
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            rows = list(csv.DictReader(file, restval="", restkey="too many"))
            names = tuple(rows[0]) if rows else ()
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"not a CSV file in UTF-8: {error}", InputLocation(source=path)) from error
    if not rows:
        raise InputError("no joint in the list; one line a joint is needed below the line of column names",
                         InputLocation(source=path))  # fmt: skip
    _check_columns(path, tuple(name for name in names if name != "too many"))
    joints = tuple(_joint(path, line, row) for line, row in enumerate(rows, start=2))
    twice = [name for name, count in Counter(one.joint.casefold() for one in joints).items() if count > 1]
    if twice:
        raise InputError(
            f"joint {twice[0]!r} stands there twice; each joint needs a name of its own, for its folder",
            InputLocation(source=path),
        )
    return joints


def _check_columns(path: Path, names: tuple[str, ...]) -> None:
    missing = [name for name in COLUMNS if name not in names]
    if missing:
        raise InputError(
            f"column {missing[0]!r} is missing; the first line must hold {','.join(COLUMNS)}, and holds "
            f"{','.join(map(str, names))}",
            InputLocation(source=path, line=1),
        )


def _joint(path: Path, line: int, row: dict[str, str]) -> FleetJoint:
    where = InputLocation(source=path, line=line)
    if "too many" in row:
        raise InputError("more fields than columns; separate several recordings by semicolons", where)
    name = row["joint"].strip()
    if not _NAME.fullmatch(name):
        raise InputError(
            f"joint {name!r} cannot name a folder; use letters, digits, dot, dash and underscore", where
        )
    train, test = (_paths(path.parent, row[column]) for column in ("train", "test"))
    for column, found in (("model", row["model"].strip()), ("train", train), ("test", test)):
        if not found:
            raise InputError(f"joint {name}: no {column} given", where)
    return FleetJoint(joint=name, model=path.parent / row["model"].strip(), train=train, test=test)


def _paths(folder: Path, text: str) -> tuple[Path, ...]:
    return tuple(folder / part.strip() for part in text.split(";") if part.strip())
