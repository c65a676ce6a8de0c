"""The command ``pvlib-fem``: the one room that talks."""

from pvlib_fem.cli.commands import main

__all__ = ["main"]
