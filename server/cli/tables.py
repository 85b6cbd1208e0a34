"""Tables on the terminal: the comparison of estimators and the plan of a campaign."""

from rich import box
from rich.console import Console
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from daq.protocol.budget import LINE_USE_LIMIT
from estimators.result import IdentificationResult, Mode, Phase
from server.reports.comparison import comparison_rows, describe_models, describe_order
from server.services.plan import CampaignPlan, PlannedRecord

# A terminal has 80 columns; the page spells these out.
SHORT_TITLES = {
    Mode.A_PRIORI: "a priori",
    Mode.A_POSTERIORI: "a post.",
    Mode.ONE_STEP_FROZEN: "frozen",
    Mode.FREE_RUN: "free run",
}


def print_comparison(console: Console, result: IdentificationResult, output_unit: str) -> None:
    """Print the table, the models and what the table means."""
    table = Table(
        title=f"adjusted R² (1 is perfect) and free-run rmse in {output_unit}",
        title_justify="left",
        title_style="bold",
        box=box.SIMPLE,
    )
    table.add_column("estimator", no_wrap=True)
    for mode in Mode:
        table.add_column(SHORT_TITLES[mode], justify="right")
    table.add_column("rmse", justify="right")
    table.add_column("ms", justify="right")
    phase = None
    for row in comparison_rows(result):
        if row.phase is not phase:
            phase = row.phase
            if phase is Phase.TEST:
                table.add_section()
            table.add_row(f"[bold]{phase.value}[/bold]")
        table.add_row(row.title, *row.figures.values(), row.free_run_rmse, row.time_ms)
    console.print(table)
    for title, lines in describe_models(result):
        console.print(Text(title, style="bold"))
        for line in lines:
            console.print(Padding(Text(line), (0, 0, 0, 2)))
    for sentence in filter(None, (*result.verdict, describe_order(result), *result.excitation.sentences)):
        console.print(Text(f"* {sentence}"))


def print_plan(console: Console, plan: CampaignPlan) -> None:
    """Print what a campaign would do."""
    console.print(
        f"{plan.campaign.name} on {plan.rig.name}: {plan.duration_s:g} s of rig time; nothing was moved",
        highlight=False,
    )
    table = Table(box=box.SIMPLE, pad_edge=False)
    table.add_column("step", min_width=24)
    for column in ("peak A", "heat A", "A/s", "rad/s", "travel rad", "line", "samples"):
        table.add_column(column, justify="right", no_wrap=True)
    for step in plan.steps:
        table.add_row(step.title, *([] if step.record is None else _predictions(step.record)))
    limits = plan.rig.limits
    table.add_section()
    table.add_row(
        "limit",
        f"{limits.current_A:g}",
        f"{limits.rated_current_A:g}",
        f"{limits.slew_A_s:g}",
        f"{limits.speed_rad_s:g}",
        f"{limits.travel_min_rad:g}..{limits.travel_max_rad:g}",
        f"{LINE_USE_LIMIT:.0%}",
    )
    console.print(table)


def _predictions(record: PlannedRecord) -> list[str]:
    report = record.report
    return [
        f"{report.peak_current_a:.3g}",
        f"{report.heat_current_a:.3g}",
        f"{report.slew_a_s:.3g}",
        f"{report.peak_speed_rad_s:.3g}",
        f"{report.position_min_rad:.1f}..{report.position_max_rad:.1f}",
        f"{record.line_use:.0%}",
        f"{record.samples}",
    ]
