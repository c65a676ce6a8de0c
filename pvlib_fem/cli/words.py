"""What the command prints, and how it ends."""

import sys
import warnings

import click

from pvlib_fem.record.columns import steers
from pvlib_fem.spelling import in_shell


def safe(text):
    """Text of a file, which cannot steer the terminal."""
    return "".join(
        f"\\x{ord(sign):02x}" if steers(sign) and sign not in "\n\t" else sign
        for sign in str(text)
    )


def say(text, err=False):
    """Print; a character that the terminal does not have becomes "?"."""
    stream = sys.stderr if err else sys.stdout
    encoding = getattr(stream, "encoding", None) or "utf-8"
    text = safe(text).encode(encoding, "replace").decode(encoding)
    click.echo(text, err=err)


def note(text):
    """What is no part of the answer goes where errors go."""
    say(f"note: {text}", err=True)


class Refused(click.ClickException):
    """An error in one line, and what to do about it below."""

    def __init__(self, reason, remedy=""):
        super().__init__(" ".join(in_shell(reason).split()))
        self.remedy = remedy

    def show(self, file=None):
        say(f"Error: {self.message}", err=True)
        if self.remedy:
            say(f"\n{self.remedy}", err=True)


class plainly:
    """Bad data end with exit code 1 and the reason in one line, without Python."""

    def __enter__(self):
        self.caught = warnings.catch_warnings()
        self.caught.__enter__()
        warnings.showwarning = lambda message, *where: note(message)
        return self

    def __exit__(self, kind, error, trace):
        self.caught.__exit__(kind, error, trace)
        if isinstance(error, (ValueError, OSError)):
            raise Refused(error) from error
        if isinstance(error, MemoryError):
            raise Refused("the record is too long for the memory") from error
        return False
