"""The summary of a fleet as one page: how many joints have which verdict, and a table that sorts by every column."""

from collections.abc import Iterable, Mapping
from html import escape
from typing import Any
from urllib.parse import quote

from server.reports.page import FRAME, STYLE

WORDS = {
    "named": "missing effects named",
    "none": "nothing missing",
    "unknown": "something missing, not in the catalogue",
    "error": "no answer: wrong input or failure",
    "waiting": "not done yet",
}
COLOURS = {
    "named": "#d55e00",
    "none": "#009e73",
    "unknown": "#cc79a7",
    "error": "#000000",
    "waiting": "#9a9a9a",
}
HEADS = (
    "joint",
    "verdict",
    "effects",
    "gap before",
    "gap after",
    "closed",
    "corrected nameplate",
    "CPU [s]",
    "note",
)
FLEET_STYLE = """
ul.counts { list-style: none; padding: 0; display: flex; flex-wrap: wrap; gap: 1rem; }
ul.counts li { border-left: 6px solid; padding: .2rem .8rem; background: #f6f8fa; }
ul.counts b { font-size: 1.5rem; display: block; }
th { cursor: pointer; position: sticky; top: 0; background: #fff; white-space: nowrap; }
th[aria-sort=ascending]::after { content: " \\25B2"; } th[aria-sort=descending]::after { content: " \\25BC"; }
th:focus-visible { outline: 2px solid #0072b2; }
:is(td, th):is(:nth-child(2), :nth-child(3), :nth-child(7), :nth-child(9)) { text-align: left; }
td:nth-child(9) { max-width: 30rem; } input { font: inherit; padding: .3rem .6rem; width: 20rem; }
body { max-width: 1400px; }
"""
SCRIPT = """<script>
const table = document.querySelector("table"), body = table.tBodies[0];
function sort(head) {
  const down = head.getAttribute("aria-sort") === "ascending", at = head.cellIndex;
  for (const other of head.parentNode.cells) other.removeAttribute("aria-sort");
  head.setAttribute("aria-sort", down ? "descending" : "ascending");
  const key = row => row.cells[at].dataset.n ?? row.cells[at].textContent;
  const empty = row => row.cells[at].textContent === "";
  const rows = [...body.rows].sort((a, b) => {
    if (empty(a) !== empty(b)) return empty(a) ? 1 : -1;
    const x = key(a), y = key(b), number = !isNaN(x) && !isNaN(y) && x !== "" && y !== "";
    const order = number ? x - y : x.localeCompare(y, undefined, {numeric: true});
    return down ? -order : order;
  });
  body.append(...rows);
}
for (const head of table.tHead.rows[0].cells) {
  head.onclick = () => sort(head);
  head.onkeydown = event => { if (event.key === "Enter" || event.key === " ") { event.preventDefault(); sort(head); } };
}
document.querySelector("input").oninput = event => {
  const wanted = event.target.value.toLowerCase();
  for (const row of body.rows) row.hidden = !row.textContent.toLowerCase().includes(wanted);
};
</script>"""

Entry = Mapping[str, Any]  # Any: values of a JSON object


def render_fleet(counts: Mapping[str, int], entries: Iterable[Entry]) -> str:
    """Return the page.

    Args:
        counts: number of joints by verdict.
        entries: lines of `fleet.json`.
    """
    boxes = "".join(
        f'<li style="border-color:{COLOURS[name]}"><b>{count}</b>{escape(WORDS[name])}</li>'
        for name, count in counts.items()
    )
    heads = "".join(f'<th tabindex="0" scope="col">{escape(head)}</th>' for head in HEADS)
    total = sum(counts.values())
    body = "\n".join(
        [
            f"<h1>Fleet of {total} {'joint' if total == 1 else 'joints'}</h1>",
            "<p class=\"sub\">Where each joint and its model part. A joint's name opens its report; a column's head "
            "sorts. Gaps in percent of the test signal.</p>",
            f'<ul class="counts">{boxes}</ul>',
            '<p><input type="search" placeholder="filter: joint, effect, error" aria-label="filter"></p>',
            f'<div class="scroll"><table><thead><tr>{heads}</tr></thead>',
            f"<tbody>{''.join(map(_row, entries))}</tbody></table></div>",
            SCRIPT,
        ]
    )
    return FRAME.format(title="Fleet summary", style=STYLE + FLEET_STYLE, script="", body=body)


def _row(entry: Entry) -> str:
    name = escape(entry["joint"])
    if entry["report"] is not None:
        name = f'<a href="{quote(entry["report"])}">{name}</a>'
    changes = [
        f"{key} {old:.4g} → {new:.4g}" for key, (old, new) in entry.get("parameter_changes", {}).items()
    ]
    notes = [*(["next experiment proposed"] if entry.get("open_question") else []), *entry.get("notes", ())]
    cells = [
        f"<td>{name}</td>",
        _text(entry["verdict"]),
        _text(_effects(entry)),
        *(_percent(entry.get(key)) for key in ("gap_before", "gap_after", "gap_closed")),
        _text("; ".join(changes)),
        _number(entry.get("cpu_s")),
        _text(entry["error"] or "; ".join(notes)),
    ]
    return f"<tr>{''.join(cells)}</tr>\n"


def _effects(entry: Entry) -> str:
    others = [one if isinstance(one, str) else " with ".join(one) for one in entry.get("equivalents", ())]
    named = ", ".join(entry.get("effects", ()))
    return f"{named} (or {', '.join(others)})" if others else named


def _text(text: str) -> str:
    return f"<td>{escape(text)}</td>"


def _percent(value: float | None) -> str:
    return "<td></td>" if value is None else f'<td data-n="{value:.8g}">{value:.2%}</td>'


def _number(value: float | None) -> str:
    return "<td></td>" if value is None else f'<td data-n="{value:.8g}">{value:.1f}</td>'
