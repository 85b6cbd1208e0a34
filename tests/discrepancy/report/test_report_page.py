"""The page as its reader gets it: complete, self-contained, the same every time."""

import re
from collections.abc import Callable
from html.parser import HTMLParser

import pytest

from discrepancy.report.page import render_report
from discrepancy.result import GapResult

Answer = Callable[[str], GapResult]


class Outline(HTMLParser):
    """Collects text, ids, addresses and labels of a page, without scripts and styles."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.text, self.ids, self.links, self.labels, self.hidden = "", [""], [""], [""], False
        self.addresses: list[str] = []
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Take ids, addresses and labels."""
        known = dict(attrs)
        self.hidden = tag in ("script", "style")
        self.ids.append(known.get("id") or "")
        self.links.append(known.get("href") or "")
        self.labels.append(known.get("aria-label") or "" if known.get("role") == "img" else "")
        self.addresses.extend(v for k, v in attrs if k in ("src", "href") and v)

    def handle_endtag(self, tag: str) -> None:
        """Leave a script or style."""
        self.hidden = self.hidden and tag not in ("script", "style")

    def handle_data(self, data: str) -> None:
        """Take text that is shown."""
        self.text += "" if self.hidden else data


@pytest.mark.parametrize("verdict", ["named", "none", "unknown"])
def test_the_page_loads_nothing_and_its_links_lead_somewhere(verdict: str, answer: Answer) -> None:
    outline = Outline(render_report(answer(verdict)))
    ids = [one for one in outline.ids if one]
    assert len(ids) == len(set(ids))
    assert all(address.startswith("#") for address in outline.addresses)
    assert {address[1:] for address in outline.addresses} <= set(ids)


@pytest.mark.parametrize("verdict", ["named", "none", "unknown"])
def test_every_figure_has_a_text_for_those_who_cannot_see_it(verdict: str, answer: Answer) -> None:
    page = render_report(answer(verdict))
    labels = [label for label in Outline(page).labels if label]
    assert len(labels) == page.count("Plotly.newPlot(") - page.split("<main>")[0].count("Plotly.newPlot(")
    assert all(len(label) > 20 for label in labels)


def test_the_same_answer_gives_the_same_page(answer: Answer) -> None:
    assert render_report(answer("named")) == render_report(answer("named"))


def test_the_first_screen_says_what_how_big_and_what_else(answer: Answer) -> None:
    text = Outline(render_report(answer("named"))).text.split("Where the simulation was wrong")[0]
    assert "The model lacks dry (Coulomb) friction; with that, nothing that matters is left." in text
    assert "Friction level 0.1500 ± 0.0012 N m" in text
    assert (
        "gap 0.0995 rad/s (14.2 % of the signal) before, below the noise floor of 0.0100 rad/s after" in text
    )
    assert "could as well be dry friction with break-away (Stribeck)" in text


def test_a_gap_below_the_floor_is_never_called_zero_or_a_hundred_percent(answer: Answer) -> None:
    text = Outline(render_report(answer("named"))).text
    assert not re.search(r"\b(0\.00|100\.0+) %", text)


def test_the_parameter_table_shows_the_refitted_joint_at_every_step(answer: Answer) -> None:
    page = render_report(answer("named"))
    table = page[page.index("Parameters at every step</h2>") :]
    row = re.search(r"<tr><td>viscous friction</td>.*?</tr>", table)
    assert row is not None
    assert re.findall(r"<td[^>]*>(.*?)</td>", row[0])[2:] == [
        "0.9000", "1.2000 ± 0.0013", "0.9000 ± 0.0013",
    ]  # fmt: skip


def test_none_says_how_small_an_effect_would_have_been_seen(answer: Answer) -> None:
    text = Outline(render_report(answer("none"))).text
    assert "What would have been seen" in text
    assert "0.0042 N m" in text


def test_unknown_shows_where_it_acts_and_offers_no_equivalents(answer: Answer) -> None:
    text = Outline(render_report(answer("unknown"))).text
    assert "Something is missing that no effect of the catalogue explains." in text
    assert "a torque that follows the speed; the speed alone predicts 70.0 %" in text
    assert "could as well be" not in text


def test_names_from_files_are_escaped(answer: Answer) -> None:
    page = render_report(answer("none"))
    assert "arm &lt;1&gt;" in page
    assert "arm <1>" not in page


def test_records_are_called_by_their_files(answer: Answer) -> None:
    plain = Outline(render_report(answer("named"))).text
    named = Outline(render_report(answer("named").with_names({"test[0]": "runs/a/slow.parquet"}))).text
    assert "test record 1: speed" in plain
    assert "slow.parquet: speed" in named
    assert "test[0]" not in named
