"""YAML that strangers send: plain data only, no anchors, not too deep; JSON is YAML too.

Anchors are refused because a few of them can stand for more text than fits a memory.
"""

import json
from typing import Any

import yaml

from server.services.errors import InvalidValueError

MAX_OCTETS = 1 << 20
_REMEDY = "send plain YAML or JSON: keys, numbers, text and lists"


class _PlainLoader(yaml.SafeLoader):
    """The safe loader without anchors."""

    def compose_node(self, parent: yaml.Node | None, index: int) -> yaml.Node | None:
        """Refuse a reference to an anchor."""
        if self.check_event(yaml.AliasEvent):
            mark = self.get_mark()
            raise yaml.constructor.ConstructorError(None, None, "references (*name) are not allowed", mark)
        return super().compose_node(parent, index)


def parse_plain_yaml(octets: bytes, field: str = "body") -> Any:  # JSON values
    """Return the data that a YAML or JSON text holds; the same data as JSON would have.

    Raises:
        InvalidValueError: too long, not UTF-8, no YAML, or nothing that JSON could hold.
    """
    if len(octets) > MAX_OCTETS:
        raise _invalid(f"a text of more than {MAX_OCTETS:,} octets is refused", field)
    try:
        content = yaml.load(octets.decode("utf-8"), Loader=_PlainLoader)  # a safe loader
        json.dumps(content, allow_nan=False, ensure_ascii=False).encode("utf-8")
    except yaml.MarkedYAMLError as error:
        where = f"line {error.problem_mark.line + 1}: " if error.problem_mark else ""
        raise _invalid(f"{where}{error.problem or error.context}", field) from error
    except RecursionError as error:
        raise _invalid("too many levels", field) from error
    except (yaml.YAMLError, ValueError, TypeError) as error:
        raise _invalid(str(error), field) from error
    return content


def _invalid(reason: str, field: str) -> InvalidValueError:
    return InvalidValueError(f"not readable: {reason}", field=field, value=None, remedy=_REMEDY)
