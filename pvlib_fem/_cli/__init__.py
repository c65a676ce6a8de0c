"""The command ``pvlib-fem``: the one room that talks."""

import click

from pvlib_fem import __version__

#: what each command does, as the list of them tells it
COMMANDS = {
    "demo": "Close the loop on a measured plant, a simulated site and a measured week.",
    "fit": "Fit FILE, or several that are joined on their times, and print the report.",
    "fleet": "Close the loop on each of the SYSTEMS of a table, or fit them.",
    "loop": "Find the effects and faults that the model misses in FILE, or several.",
    "modules": "Compare the module sensors of FILE: what is common, what is one's own.",
    "parameters": "Give the thermal parameters of FIT as pvlib, PVsyst and SAM take "
    "them.",
    "recover": "Put effects into FILE, and find from what size the loop sees them.",
    "screen": "Find what FILE holds that was not measured: codes, spikes, stuck "
    "sensors …",
}


class OnDemand(click.Group):
    """Commands that are loaded when they are called, so that a list of them is not."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return [*COMMANDS]

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        from pvlib_fem._cli import commands

        return getattr(commands, name) if name in COMMANDS else None

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        name = click.utils.make_str(args[0])
        if name in COMMANDS or name.startswith("-"):
            return super().resolve_command(ctx, args)
        from pvlib_fem._spelling import did_you_mean

        near = did_you_mean(name, COMMANDS)
        ctx.fail(f"no such command {name!r}{near}; there are {', '.join(COMMANDS)}")

    def format_commands(
        self, ctx: click.Context, formatter: click.HelpFormatter
    ) -> None:
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))


@click.group(cls=OnDemand, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="pvlib-fem")
def main() -> None:
    """The temperature of PV modules, second by second, from measured data.

    With a new file begin with --guess: it proposes the command that reads it.
    """
