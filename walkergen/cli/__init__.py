"""Command line: `walkergen COMMAND`. Each command is made from a request, runs it and shows the report."""

import logging
import os
import signal
import sys
import threading
from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Annotated, Any

import typer
from typer.main import get_command

from walkergen import __version__
from walkergen.cli import command_builder, streams
from walkergen.cli.command_builder import HELP_OPTIONS, Group
from walkergen.command_table import COMMANDS, for_shell
from walkergen.core.errors import OutputError, WalkergenError, use_spelling
from walkergen.core.files import safe_text

INTERRUPTED_CODE = 130
"""Exit code after Ctrl-C."""

INTERRUPTED_MESSAGE = "interrupted: finished files are complete. Run the same command again for the rest."

SWEPT_KEYS = {"--tilt": "legs.tilt_deg", "--gamma": "scene.drive.gamma", "--frequency": "scene.drive.frequency_hz"}
"""Keys that `sweep` sets with --set, by the options of other commands that set them."""


class Root(Group):
    """Group of all commands. Each is imported only when it is looked up."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings | {"commands": command_builder.Commands()})

    @cached_property
    def sentences(self) -> Mapping[str, tuple[str, str]]:  # type: ignore[override]
        """Heading in the help, and summary, of every command, by the command's name."""
        return {name: (entry.heading, command_builder.command_summary(name)) for name, entry in COMMANDS.items()}


command_line = typer.Typer(
    name="walkergen",
    help="From a leg tilt to 3D-printed walkers that run on a vibrating plate as predicted.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    cls=Root,
    context_settings=HELP_OPTIONS,
    rich_markup_mode=None,  # boxes and columns of types leave no room for words
    epilog="walkergen COMMAND -h shows a command's options and examples.",
)


@command_line.callback(invoke_without_command=True)
def _options(
    context: typer.Context,
    version: Annotated[bool, typer.Option("--version", help="Show the version.")] = False,
    verbose: Annotated[
        bool, typer.Option("--verbose", help="With --version: also show Python, numba and the cache.")
    ] = False,
) -> None:
    """From a leg tilt to 3D-printed walkers that run on a vibrating plate as predicted."""
    if version:
        typer.echo(f"walkergen {__version__}")
        if verbose:
            _show_versions()
        raise typer.Exit
    if verbose:
        context.fail("--verbose needs --version")
    if context.invoked_subcommand is None:
        context.fail("Missing command.")


def _show_versions() -> None:
    """Print the versions and the locations that a bug report needs."""
    import platform
    from importlib.metadata import version

    from walkergen.core import caches

    print(f"Python {platform.python_version()} on {platform.system()} {platform.machine()}")
    print(f"numba {version('numba')}")
    try:
        print(f"cache {caches.home()}, {caches.size() / 1e6:.1f} MB: can be deleted at any time")
    except OSError as error:
        print(f"cache of this process alone: {error}")


def main(commands: typer.Typer | Callable[[], None] = command_line) -> None:
    """Run the command line and exit. Errors are lines on standard error.

    Exit codes are 0 after success, 1 if a file or a stream could not be written or a test failed, 2 if the input is
    unusable, and 130 after Ctrl-C.
    """
    error_stream = streams.prepare()
    lost_interrupt = streams.catch_interrupts()
    safe_text.guard_output()
    # Fixed here: drawing does not depend on settings of other programs
    os.environ["MPLBACKEND"] = "agg"
    os.environ.pop("SOURCE_DATE_EPOCH", None)
    os.environ["PYDANTIC_DISABLE_PLUGINS"] = "__all__"  # of others, found in every package
    # without a cache folder it makes one for this process, as `caches` does: no message is needed
    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    with use_spelling(for_shell):
        code = _run_command(commands, lost_interrupt)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # all output is written; only Python's own end is left
    if code == INTERRUPTED_CODE:
        streams.exit_now(INTERRUPTED_CODE)
    sys.exit(code or int(error_stream.lost))


def _run_command(commands: typer.Typer | Callable[[], None], lost_interrupt: threading.Event) -> int:
    """Run the command line, print its error and return the exit code. `lost_interrupt`: set if Ctrl-C was lost."""
    try:
        try:
            # A Typer that is called would replace our hook, which receives a lost Ctrl-C
            (get_command(commands) if isinstance(commands, typer.Typer) else commands)()
        except SystemExit as done:
            sys.stdout.flush()
            if sys.argv[1:2] == ["sweep"] and (key := SWEPT_KEYS.get(getattr(done.__context__, "option_name", ""))):
                print(f"Write --set {key}=VALUES.", file=sys.stderr)
            if isinstance(getattr(done.__context__, "__cause__", None), KeyboardInterrupt):
                raise KeyboardInterrupt from None
            return done.code if isinstance(done.code, int) else int(done.code is not None)
    except KeyboardInterrupt:
        return _print_error(INTERRUPTED_MESSAGE, INTERRUPTED_CODE)
    except OutputError as error:
        return _print_error(str(error), 1)
    except WalkergenError as error:
        return _print_error(str(error), 2)
    except BrokenPipeError:  # the reader of our output has gone (walkergen ... | head)
        streams.discard_output()
        return 1
    except MemoryError:
        return _print_error("not enough memory. Try a smaller job.", 1)
    except ImportError as error:  # a Ctrl-C while a library loads may come as its failure
        if not (lost_interrupt.is_set() or isinstance(error.__cause__, KeyboardInterrupt)):
            raise
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # it is sent again
        return _print_error(INTERRUPTED_MESSAGE, INTERRUPTED_CODE)
    except OSError as error:
        what = "" if error.filename is None else f"{str(error.filename)!r}: "
        return _print_error(f"{what}{error.strerror or error}", 1)
    raise AssertionError("typer always exits")


def _print_error(message: str, code: int) -> int:
    """Flush standard output, print each line of a message as an error, and return the exit code `code`."""
    try:
        sys.stdout.flush()
    except OSError:
        streams.discard_output()
    for line in message.splitlines():
        print(f"error: {line}", file=sys.stderr)
    return code
