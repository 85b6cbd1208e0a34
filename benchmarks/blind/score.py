"""Open the answers of solved blind cases and count: `python -m benchmarks.blind.score ROOT`."""

import json
import math
import sys
from collections import Counter
from pathlib import Path
from typing import Any

from discrepancy.effects.table import EFFECTS

KINDS = ("right", "miss", "unknown", "wrong")


def classify(hidden: list[str], verdict: dict[str, Any]) -> str:
    """Return what the answer to one case is worth.

    `right`: verdict `named` and every hidden effect is named or declared equivalent to one that is, with no name
    beyond them; nothing hidden: `none`; an effect from outside the catalogue hidden: `unknown` without a name.
    `wrong`: a name stands that is neither hidden nor declared equivalent to a hidden effect, whatever the verdict.
    `unknown`: something is left, no wrong name stands. `miss`: `none`, or some of several effects not named.
    """
    steps = [step for step in verdict["steps"] if step["added"] is not None]
    wanted = _in_parts(hidden, {step["added"] for step in steps})
    open_names = set(wanted)
    for step in steps:
        # Each name that stands must account for something that was hidden.
        covered = next((entry for entry in _readings(step) if entry <= open_names), None)
        if covered is None:
            return "wrong"
        open_names -= covered
    outside = any(name not in EFFECTS for name in hidden)
    if verdict["verdict"] == "unknown":
        return "right" if outside and not steps else "unknown"
    named = verdict["verdict"] == ("named" if hidden else "none")
    return "right" if named and not open_names else "miss"


def _readings(step: dict[str, Any]) -> list[frozenset[str]]:
    """Return what a step may stand for: the name that it added, or any of its declared equivalents."""
    entries = [step["added"], *step["equivalents"]]
    return [frozenset([entry] if isinstance(entry, str) else entry) for entry in entries]


def _in_parts(hidden: list[str], named: set[str]) -> list[str]:
    """Return the hidden effects; asymmetric dry friction as the level and the offset that it is, if these are named."""
    whole, offsets = "asymmetric_coulomb_friction", {"load_torque_offset", "current_sensor_offset"}
    if whole not in hidden or "coulomb_friction" not in named or not offsets & named:
        return hidden
    return [name for name in hidden if name != whole] + ["coulomb_friction", min(offsets & named)]


def wilson(hits: int, total: int) -> tuple[float, float]:
    """Return the 95 % Wilson interval of a share."""
    if total == 0:
        return 0.0, 1.0
    z, share = 1.96, hits / total
    centre = (share + z * z / (2 * total)) / (1 + z * z / total)
    half = z * math.sqrt(share * (1 - share) / total + z * z / (4 * total**2)) / (1 + z * z / total)
    return centre - half, centre + half


def main(root: Path) -> None:
    """Print one line a case and, for each kind of case, the totals."""
    counts: dict[str, Counter[str]] = {"hidden": Counter(), "nothing hidden": Counter(), "outside": Counter()}
    for folder in sorted(root.iterdir()):
        if not (folder / "verdict.json").exists():
            continue
        verdict = json.loads((folder / "verdict.json").read_text(encoding="utf-8"))
        answer = json.loads((folder / "answer.json").read_text(encoding="utf-8"))
        hidden = [effect["id"] for effect in answer["effects"]]
        kind = classify(hidden, verdict)
        outside = any(name not in EFFECTS for name in hidden)
        counts["outside" if outside else "hidden" if hidden else "nothing hidden"][kind] += 1
        equivalents = [step["equivalents"] for step in verdict["steps"][1:]]
        gap = f"{verdict['gap_before']:.4f} -> {verdict['gap_after']:.4f}"
        print(
            f"{kind:8s} {'+'.join(hidden) or 'nothing':28s} {verdict['verdict']:7s} {verdict['effects']} "
            f"{equivalents} {gap} {verdict['seconds']:.1f} s"
        )
    for label, counter in counts.items():
        total = counter.total()
        for kind in KINDS if total else ():
            low, high = wilson(counter[kind], total)
            print(f"{label}: {kind} {counter[kind]} of {total} ({low:.1%} to {high:.1%})")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
