"""The blind benchmark's tables in Markdown."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from benchmarks.blind.conditions import CONDITIONS
from benchmarks.blind.figures import VISIBLE, Solved
from benchmarks.blind.judge import Worth, wilson

Conditions = Mapping[str, Sequence[Solved]]


def case_line(one: Solved) -> str:
    """Return one case in a line."""
    hidden = "+".join(one.answer.hidden) or "nothing"
    shrink = "" if one.shrink is None else f" shrink {one.shrink:.1f}"
    time = "" if one.seconds is None else f" {one.seconds[0]:.1f} s ({one.seconds[1]:.1f} s CPU)"
    return (
        f"{one.answer.condition:14s} {one.worth.value:7s} {hidden:44s} gap {one.gap:7.2f} {one.verdict:7s} "
        f"{'+'.join(one.added)}{shrink}{time}"
    )


def share(hits: int, total: int) -> str:
    """Return a share with its 95 % Wilson interval."""
    if total == 0:
        return "-"
    low, high = wilson(hits, total)
    return f"{hits}/{total} = {hits / total:.1%} ({low:.1%} to {high:.1%})"


def _row(*cells: object) -> str:
    return "| " + " | ".join(str(cell) for cell in cells) + " |"


def _head(*cells: str) -> list[str]:
    return [_row(*cells), "|" + "---|" * len(cells)]


def condition_table(solved: Conditions) -> list[str]:
    """Return right, wrong, miss and unknown of each condition, of visible effects and of all."""
    lines = _head(
        "condition",
        "cases",
        "right name or class",
        "wrong name",
        "of these with verdict `named`",
        "miss",
        "unknown",
    )
    for name, cases in solved.items():
        groups = {f"{name}, gap >= {VISIBLE} noise rms": [one for one in cases if one.visible]}
        if len(next(iter(groups.values()))) < len(cases):
            groups[f"{name}, all"] = list(cases)
        if CONDITIONS[name].hidden == 0:
            groups = {name: list(cases)}
        for label, group in groups.items():
            lines.append(_counts(label, group))
    return lines


def _counts(label: str, group: Sequence[Solved]) -> str:
    total = len(group)

    def count(wanted: Callable[[Solved], bool]) -> str:
        return share(sum(map(wanted, group)), total)

    return _row(
        label,
        total,
        count(lambda one: one.worth is Worth.RIGHT),
        count(lambda one: one.worth is Worth.WRONG),
        sum(one.worth is Worth.WRONG and one.verdict == "named" for one in group),
        count(lambda one: one.worth is Worth.MISS),
        count(lambda one: one.worth is Worth.UNKNOWN),
    )


def figure_table(solved: Conditions) -> list[str]:
    """Return gap shrink, parameter error, coverage and time of each condition."""
    lines = _head(
        "condition", "gap shrink, median", "10 % quantile", "parameter error, median", "95 % intervals that cover",
        "time a case, median", "worst", "CPU, median", "worst",
    )  # fmt: skip
    for name, cases in solved.items():
        shrinks = [one.shrink for one in cases if one.shrink is not None]
        errors = [error for one in cases for error in one.errors.values()]
        covered = [hit for one in cases for hit in one.covered.values()]
        wall = [one.seconds[0] for one in cases if one.seconds is not None]
        cpu = [one.seconds[1] for one in cases if one.seconds is not None]
        lines.append(
            _row(
                name,
                _quantile(shrinks, 0.5, "{:.1f}"),
                _quantile(shrinks, 0.1, "{:.1f}"),
                _quantile(errors, 0.5, "{:.2%}"),
                share(sum(covered), len(covered)),
                *(_quantile(times, q, "{:.1f} s") for times in (wall, cpu) for q in (0.5, 1.0)),
            )
        )
    return lines


def _quantile(values: Sequence[float], q: float, form: str) -> str:
    return form.format(float(np.quantile(values, q))) if values else "-"


def outside_table(solved: Conditions) -> list[str]:
    """Return how often `unknown` was the answer to effects from outside the catalogue, and where it pointed."""
    lines = _head(
        "outside the catalogue",
        "cases",
        "`unknown`, no name",
        "with right port and driver",
        "any name stands",
    )
    for cases in solved.values():
        for name in dict.fromkeys(one.answer.id for one in cases):
            group = [one for one in cases if one.answer.id == name]
            outside = [one for one in group if not one.answer.truth.get(name) and name in _outside()]
            if outside:
                lines.append(_outside_row(f"{group[0].answer.condition}: {name}", outside))
                visible = [one for one in outside if one.visible]
                if 0 < len(visible) < len(outside):
                    lines.append(_outside_row(f"the same, gap >= {VISIBLE} noise rms", visible))
    return lines if len(lines) > 2 else []


def _outside() -> set[str]:
    return set(CONDITIONS["outside"].ids) | set(CONDITIONS["second_outside"].ids)


def _outside_row(label: str, group: Sequence[Solved]) -> str:
    total = len(group)
    right = [one for one in group if one.worth is Worth.RIGHT]
    return _row(
        label,
        total,
        share(len(right), total),
        share(sum(one.found_place for one in right), total),
        share(sum(bool(one.added) for one in group), total),
    )


def id_table(solved: Conditions) -> list[str]:
    """Return right answers (interval), wrong ones, median gap and parameter error of each id in each condition."""
    lines = _head("condition", "id", "right", "wrong", "median gap, noise rms", "parameter error, median")
    for name, cases in solved.items():
        for effect in dict.fromkeys(one.answer.id for one in cases):
            group = [one for one in cases if one.answer.id == effect]
            right = sum(one.worth is Worth.RIGHT for one in group)
            wrong = sum(one.worth is Worth.WRONG for one in group)
            gaps = [one.gap for one in group if np.isfinite(one.gap)]
            errors = [error for one in group for error in one.errors.values()]
            lines.append(
                _row(
                    name, effect, share(right, len(group)), wrong or "",
                    _quantile(gaps, 0.5, "{:.2f}"), _quantile(errors, 0.5, "{:.2%}"),
                )
            )  # fmt: skip
    return lines
