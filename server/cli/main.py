"""Entry point: one typer application, and the only place where an error becomes a line and an exit code.

Command modules import nothing heavier than typer at their top; services are imported when their command
runs, so that `jointscope identify` does not wait for what only `jointscope run` needs.
"""

import sys
import traceback
from collections.abc import Sequence

import typer

from server.cli import convert, demo, gap, identify, rigs, run, serve, simulate, token
from server.cli.exit_codes import ExitCode, exit_code

HELP = """Find out what a motor-driven robot joint really does.

Example: [bold]jointscope run config/campaigns/paper.yaml --emulate config/scenarios/nominal.yaml[/bold]

Exit codes: 0 done, 1 the run failed, 2 wrong input, 3 the rig refused or tripped.
"""

app = typer.Typer(
    name="jointscope", help=HELP, no_args_is_help=True, rich_markup_mode="rich", add_completion=False
)


@app.callback()
def options(
    debug: bool = typer.Option(False, "--debug", help="Show the traceback of an error."),
) -> None:
    """Accept options that stand before the command; `main` reads --debug itself, since errors end there."""


for module in (run, identify, gap, simulate, convert, rigs, demo, serve, token):
    module.register(app)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return the exit code.

    Args:
        arguments: what follows the program's name; None takes the process's own.
    """
    given = list(sys.argv[1:] if arguments is None else arguments)
    debug = "--debug" in given
    # Accepted anywhere on the line: people add it after the command that just failed.
    given = [argument for argument in given if argument != "--debug"]
    try:
        result = app(given, prog_name="jointscope", standalone_mode=False)
    except typer.TyperException as error:
        return _report(error, error.format_message(), ExitCode.WRONG_INPUT, debug)
    except (Exception, KeyboardInterrupt) as error:  # noqa: BLE001  # the outermost loop
        return _report(error, _one_line(error), exit_code(error), debug)
    return result if isinstance(result, int) else ExitCode.DONE


def _report(error: BaseException, message: str, code: ExitCode, debug: bool) -> int:
    if debug:
        traceback.print_exception(error)
    sys.stderr.write(f"jointscope: {message}\n")
    return code


def _one_line(error: BaseException) -> str:
    if isinstance(error, KeyboardInterrupt):
        return "interrupted"
    text = " ".join(str(error).split()) or type(error).__name__
    if exit_code(error) is ExitCode.FAILED and not _is_expected(error):
        return f"internal error: {type(error).__name__}: {text}; run again with --debug and report it"
    return text


def _is_expected(error: BaseException) -> bool:
    from daq.errors import DaqError
    from server.errors import RunFailedError
    from server.services.errors import ConflictError, NotFoundError

    return isinstance(error, DaqError | RunFailedError | OSError | ConflictError | NotFoundError)
