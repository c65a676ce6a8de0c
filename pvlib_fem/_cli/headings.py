"""Options under headings, and examples, in the help of a command."""

from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from typing import Any

import click

#: headings of a help page, in this order
COLUMNS, TIMES, LAYOUT = "Columns and units", "Times", "Layout of the file"
SITE, MODEL, EFFECTS = "Site and irradiance", "Model and fit", "Effects"
KNOWN, PARAMETERS = "Effects of known size", "Parameters"
SIMULATED = "Simulated record"
SYSTEMS, OUTPUT, OTHER = "Systems and workers", "Output", "Other"
ORDER = (
    *(COLUMNS, TIMES, LAYOUT, SITE, MODEL, EFFECTS, KNOWN, PARAMETERS),
    *(SIMULATED, SYSTEMS, OUTPUT, OTHER),
)
EACH = (TIMES, LAYOUT)  # headings of options that each file may have of its own
WRITTEN = click.Path(dir_okay=False, path_type=Path)


class Option(click.Option):
    """An option under a heading."""

    def __init__(self, *names: Any, heading: str = OTHER, **attributes: Any) -> None:
        super().__init__(*names, **attributes)
        self.heading = heading


class Command(click.Command):
    """A command whose help has options under headings, and examples at its end."""

    def __init__(
        self, *args: Any, examples: Iterable[str] = (), **attributes: Any
    ) -> None:
        super().__init__(*args, **attributes)
        self.examples = tuple(examples)

    def format_options(
        self, ctx: click.Context, formatter: click.HelpFormatter
    ) -> None:
        """Write the options, each under its heading."""
        under: dict[str, list] = {heading: [] for heading in ORDER}
        for param in self.get_params(ctx):
            row = param.get_help_record(ctx)
            if row is not None and isinstance(param, click.Option):
                under[getattr(param, "heading", OTHER)].append(row)
        for heading, rows in under.items():
            if rows:
                with formatter.section(heading):
                    if heading in EACH:
                        formatter.write_text("Once for all files, or once for each.")
                    formatter.write_dl(rows)

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the examples as they are."""
        title = "Example" if len(self.examples) == 1 else "Examples"
        with formatter.section(title):
            for line in self.examples:
                formatter.write(f"{'':>{formatter.current_indent}}{line}\n")


def command_with(*examples: str) -> Callable:
    """
    Decorator for a command with these examples.

    Parameters
    ----------
    *examples : str
        Command lines at the end of the help page, in this order.

    Returns
    -------
    callable
        Makes a :class:`Command` of a function.
    """
    return click.command(cls=Command, examples=examples)


def option_maker(heading: str) -> Callable:
    """
    Maker of options under one heading.

    Parameters
    ----------
    heading : str
        One of ``ORDER``.

    Returns
    -------
    callable
        Takes the arguments of ``click.option`` and returns the decorator of a command.
    """
    return partial(click.option, cls=Option, heading=heading)


def with_options(*options: Callable) -> Callable:
    """
    Decorator of a command with options, in this order.

    Parameters
    ----------
    *options : callable
        Decorators, as ``click.option`` and this function return them.

    Returns
    -------
    callable
        Adds all options to a command.
    """

    def decorated(command: Callable) -> Callable:
        for option in options[::-1]:
            command = option(command)
        return command

    return decorated
