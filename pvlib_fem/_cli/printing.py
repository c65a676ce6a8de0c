"""What the command prints, and how it ends."""

import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Event, Timer
from types import TracebackType
from typing import IO, Any, Self

import click

from pvlib_fem._record.column_names import steers
from pvlib_fem._spelling import in_shell


def safe(text: object) -> str:
    r"""
    Text of a file, which cannot steer the terminal.

    Parameters
    ----------
    text : object
        Anything that has a text.

    Returns
    -------
    str
        Its text; of control and direction signs but new lines and tabs the code, such
        as ``\x1b``.
    """
    return "".join(
        f"\\x{ord(sign):02x}" if steers(sign) and sign not in "\n\t" else sign
        for sign in str(text)
    )


def say(text: object, err: bool = False) -> None:
    """
    Print; a character that the terminal does not have becomes "?".

    Parameters
    ----------
    text : object
        Anything that has a text.
    err : bool, default False
        Print on the standard error instead of the standard output.
    """
    stream = sys.stderr if err else sys.stdout
    encoding = getattr(stream, "encoding", None) or "utf-8"
    text = safe(text).encode(encoding, "replace").decode(encoding)
    click.echo(text, err=err)


def note(text: object) -> None:
    """
    Print a note on the standard error, since it is no part of the answer.

    Parameters
    ----------
    text : object
        Anything that has a text.
    """
    say(f"note: {text}", err=True)


PATIENCE = 1.0  # s, from which waiting is explained


@contextmanager
def waiting(words: str) -> Iterator[None]:
    """
    Say on a terminal what is done, where it takes longer than a second.

    The line goes away at the end. Elsewhere, as in a pipe or a log, nothing is said.

    Parameters
    ----------
    words : str
        What is done, in one line.

    Yields
    ------
    None
    """
    stream, shown = sys.stderr, Event()
    if not stream.isatty():
        yield
        return

    def show() -> None:
        stream.write(words)
        stream.flush()
        shown.set()

    timer = Timer(PATIENCE, show)
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()
        timer.join()
        if shown.is_set():
            stream.write(f"\r{'':{len(words)}}\r")
            stream.flush()


class Refused(click.ClickException):
    """An error in one line, and what to do about it below."""

    def __init__(self, reason: Exception | str, remedy: str = "") -> None:
        super().__init__(" ".join(in_shell(reason).split()))
        self.remedy = remedy

    def show(self, file: IO[Any] | None = None) -> None:
        say(f"Error: {self.message}", err=True)
        if self.remedy:
            say(f"\n{self.remedy}", err=True)


#: makes of an error of reading the refusal that the command ends with
Otherwise = Callable[[Exception], Refused]


class Interrupted(click.ClickException):
    """Ctrl-C, and how to go on, in one line."""

    exit_code = 130  # 128 and the number of SIGINT, as of a shell

    def show(self, file: IO[Any] | None = None) -> None:
        say(f"Interrupted: {self.message}" if self.message else "Interrupted", err=True)


class plainly:
    """
    Bad data end with exit code 1 and the reason in one line, without Python.

    Parameters
    ----------
    after_interrupt : callable, optional
        Gives the words that say after Ctrl-C how to go on.
    """

    def __init__(self, after_interrupt: Callable[[], str] = lambda: "") -> None:
        self.after_interrupt = after_interrupt

    def __enter__(self) -> Self:
        self.caught = warnings.catch_warnings()
        self.caught.__enter__()
        warnings.showwarning = lambda message, *where: note(message)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.caught.__exit__(kind, error, trace)
        if isinstance(error, (ValueError, OSError)):
            raise Refused(error) from error
        if isinstance(error, KeyboardInterrupt):
            raise Interrupted(self.after_interrupt()) from error
        if isinstance(error, MemoryError):
            raise Refused("the record is too long for the memory") from error
