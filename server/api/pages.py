"""The plain status page and the API's documentation page: static HTML, nothing fetched from elsewhere."""

from collections.abc import Iterator, Mapping
from html import escape
from typing import Any

_STYLE = """body{font:16px/1.5 system-ui,sans-serif;max-width:60rem;margin:2rem auto;padding:0 1rem}
:root{color-scheme:light dark}
code{font-family:ui-monospace,monospace}section{border-top:1px solid #8886;padding:.5rem 0}h3{margin:.5rem 0}
table{border-collapse:collapse}td,th{text-align:left;padding:.1rem 1rem .1rem 0;vertical-align:top}"""
_METHODS = ("get", "post", "put", "patch", "delete")
Json = Mapping[str, Any]  # JSON values


def status_page() -> str:
    """Return the page at `/`."""
    return _page(
        "Jointscope",
        "<h1>Jointscope</h1><p>The service is running.</p><ul>"
        '<li><a href="docs">The API in words</a></li><li><a href="openapi.json">The API as OpenAPI document</a></li>'
        '<li><a href="healthz">Health</a>, <a href="readyz">readiness</a>, <a href="metrics">metrics</a></li></ul>'
        "<p>Requests to <code>/api/v1</code> need a token: <code>jointscope token create</code> makes one.</p>",
    )


def docs_page(openapi: Json) -> str:
    """Return the API's documentation, made of its OpenAPI document."""
    parts = [f"<h1>{escape(openapi['info']['title'])}</h1><p>{escape(openapi['info']['description'])}</p>"]
    parts += [
        "".join(_operation(path, method, operations[method]))
        for path, operations in openapi["paths"].items()
        for method in _METHODS
        if method in operations
    ]
    return _page("Jointscope: the API", "".join(parts))


def _operation(path: str, method: str, operation: Json) -> Iterator[str]:
    yield f"<section><h3><code>{method.upper()} {escape(path)}</code></h3>"
    yield f"<p>{escape(operation.get('description', operation.get('summary', '')))}</p>"
    rows = [
        f"<tr><td><code>{escape(each['name'])}</code></td><td>{escape(each['in'])}</td>"
        f"<td>{escape(each.get('description', ''))}</td></tr>"
        for each in operation.get("parameters", [])
    ]
    if rows:
        yield f"<table><tr><th>parameter</th><th>in</th><th></th></tr>{''.join(rows)}</table>"
    answers = ", ".join(status for status in operation["responses"])
    yield f"<p>Answers: {escape(answers)}</p></section>"


def _page(title: str, body: str) -> str:
    return (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{escape(title)}</title>'
        f'<meta name="viewport" content="width=device-width"><style>{_STYLE}</style></head><body>{body}</body></html>'
    )
