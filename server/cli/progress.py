"""Renders a run's progress: bars on a terminal, plain lines elsewhere (logs, CI)."""

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TaskProgressColumn, TextColumn, TimeElapsedColumn

MARKS = {"done": "[green]done[/green]"}
# Without a terminal a long step says how far it is this often, as a share of the step.
PLAIN_STEP = 0.25


class BarListener:
    """Progress bars on a terminal; use as a context manager."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._progress = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            TaskProgressColumn(),
            TimeElapsedColumn(),
            TextColumn("{task.fields[detail]}"),
            console=console,
        )
        self._task: TaskID | None = None

    def __enter__(self) -> "BarListener":
        self._progress.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._progress.stop()

    def step_started(self, index: int, count: int, title: str) -> None:
        """Begin a bar of unknown length."""
        description = f"[{index + 1}/{count}] {title}".replace("[", r"\[", 1)
        self._task = self._progress.add_task(description, total=None, detail="")

    def step_progress(self, done_s: float, total_s: float, detail: str) -> None:
        """Move the bar."""
        if self._task is not None:
            self._progress.update(self._task, completed=done_s, total=total_s, detail=detail)

    def step_ended(self, title: str, ended: str, detail: str) -> None:
        """Fill the bar, or leave it where the step ended."""
        if self._task is None:
            return
        if ended == "done":
            total = self._progress.tasks[-1].total or 1.0
            self._progress.update(self._task, completed=total, total=total)
        self._progress.update(self._task, detail=f"{MARKS.get(ended, f'[red]{ended}[/red]')} {detail}")
        self._progress.stop_task(self._task)
        self._task = None

    def note(self, text: str) -> None:
        """Print a line above the bars."""
        self._console.print(text, highlight=False, markup=False)


class LineListener:
    """Plain lines, for when nobody watches a terminal."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._next = PLAIN_STEP

    def __enter__(self) -> "LineListener":
        return self

    def __exit__(self, *_: object) -> None:
        return None

    def step_started(self, index: int, count: int, title: str) -> None:
        """Say which step begins."""
        self._next = PLAIN_STEP
        self._print(f"[{index + 1}/{count}] {title}")

    def step_progress(self, done_s: float, total_s: float, detail: str) -> None:
        """Say at every quarter how far the step is."""
        share = done_s / total_s if total_s > 0 else 1.0
        if share >= self._next:
            self._next = PLAIN_STEP * (int(share / PLAIN_STEP) + 1)
            self._print(f"      {share:4.0%} {detail}")

    def step_ended(self, title: str, ended: str, detail: str) -> None:
        """Say how the step ended."""
        self._print(f"      {ended}: {detail}" if detail else f"      {ended}")

    def note(self, text: str) -> None:
        """Print one line."""
        self._print(text)

    def _print(self, text: str) -> None:
        self._console.print(text, highlight=False, markup=False, soft_wrap=True)


def make_listener(console: Console) -> BarListener | LineListener:
    """Return what suits the console."""
    return BarListener(console) if console.is_terminal else LineListener(console)
