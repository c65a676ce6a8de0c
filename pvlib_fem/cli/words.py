"""What the package says, in the words of its command."""

import re
import sys
import warnings

import click

from pvlib_fem.record.columns import steers

#: what a library's message says in Python, and the option that is meant
OPTIONS = (
    (r"give convert_units=True \(--convert\)", "give --convert"),
    (r"module_area=\d+ \((--module-area \d+)\)", r"\1"),
    (r"check_units=False \((--no-unit-check)\)", r"\1"),
    (r"check_units=False", "--no-unit-check"),
    (
        r"^(\w+)( and \w+)? (looks? to be in) (\S+):(.*) Convert it first; if the unit "
        r"is right, give",
        r"\1\2 \3 \4:\5 Give --unit \1=\4 to convert it; if the unit is right, give",
    ),
    (
        r"with data\.tz_localize\('([\w/+-]+)',\s+ambiguous='infer'\)(?: \(--tz "
        r"[\w/+-]+\))?",
        r"with --tz \1",
    ),
    (r"use data\.sort_index\(\)", "give --sort"),
    (
        r"keep one, for example with data\[~data\.index\.duplicated\(\)\]",
        "give --drop-doubled to keep the first",
    ),
    (
        r"clean the column, for example with pd\.to_numeric\(column, "
        r"errors='coerce'\)",
        "give --missing TEXT for a text that stands for a missing value",
    ),
    (r"; use np\.degrees", "; multiply it by 57.3"),
    (r" \(tz_localize\)", " (--tz)"),
    (r"data\.tz_convert\(zone\) \(--tz\)", "--tz"),
    (r"for example with tz_convert\('([\w/+-]+)'\)", r"with --tz \1"),
    (r"raise calm_wind", "raise --calm-wind"),
    (r"lower min_points, or ", ""),
    (r"\bmin_gain=", "--min-gain "),
    (r"\b(method|dynamics|model)=[\"']?(\w+)[\"']?", r"--\1 \2"),
    (r"\bnight=False", "the usual rows"),
    (r"\bfixed (has|holds)\b", r"--fix \1"),
    (r"\bfixed (\S+) = ", r"--fix \1="),
    (r"; pvlib_fem\.drivers\.sun finds the sun", "; --lat and --lon find the sun"),
    (r"align them first, for example as columns of one DataFrame", "join them first"),
)


def translated(message):
    """A message of the library as a person at a shell needs it."""
    for python, option in OPTIONS:
        message = re.sub(python, option, message, flags=re.DOTALL)
    return message


def safe(text):
    """Text of a file, which cannot steer the terminal."""
    return "".join(
        f"\\x{ord(sign):02x}" if steers(sign) and sign not in "\n\t" else sign
        for sign in str(text)
    )


def say(text, err=False):
    """Print, also where the terminal lacks a sign."""
    stream = sys.stderr if err else sys.stdout
    encoding = getattr(stream, "encoding", None) or "utf-8"
    text = safe(text).encode(encoding, "replace").decode(encoding)
    click.echo(text, err=err)


def note(text):
    """What is no part of the answer goes where errors go."""
    say(f"note: {text}", err=True)


class Refused(click.ClickException):
    """An error in one line, and what to do about it below."""

    def __init__(self, message, remedy=""):
        super().__init__(" ".join(translated(str(message)).split()))
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
