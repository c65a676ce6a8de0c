"""What Python and a shell spell differently, in one message."""

import difflib
from collections.abc import Iterable, Sequence
from dataclasses import fields, is_dataclass
from typing import Any, Self

import pandas as pd


class ShellText(str):
    """A text as Python has it; ``shell`` is the same for the command line."""

    shell: str

    # the default is what unpickling and copying call, and then set the shell's
    def __new__(cls, python: str, shell: str = "") -> Self:
        text = super().__new__(cls, python)
        text.shell = shell
        return text


def spelled(*parts: str) -> ShellText:
    """
    Join parts of a text, of which some are spelled differently in a shell.

    Parameters
    ----------
    *parts : str or ShellText

    Returns
    -------
    ShellText
    """
    return ShellText("".join(parts), "".join(map(in_shell, parts)))


def no_columns(names: Sequence[str]) -> str:
    """
    Say that data have none of some columns.

    Parameters
    ----------
    names : sequence of str

    Returns
    -------
    str
        The begin of a message.
    """
    return f"the data have no column{'s' * (len(names) > 1)} {', '.join(names)}"


def refusal(*parts: str) -> ValueError:
    """
    Make the error of bad input from parts of a text.

    Parameters
    ----------
    *parts : str or ShellText

    Returns
    -------
    ValueError
        Not raised; its argument is a :class:`ShellText`.
    """
    return ValueError(spelled(*parts))


def in_shell(text: object) -> str:
    """
    A text, or the message of an error, as the command line spells it.

    Parameters
    ----------
    text : str, Exception or object
        Without a spelling for the shell it is its ``str``.

    Returns
    -------
    str
    """
    said = text.args[0] if isinstance(text, Exception) and text.args else text
    return said.shell if isinstance(said, ShellText) else str(text)


def argument(name: str, value: object) -> ShellText:
    """
    An argument with its value, which is also an option of the command.

    Parameters
    ----------
    name : str
        Name in Python, ``"module_area"`` for ``--module-area``.
    value : object

    Returns
    -------
    ShellText
        Such as ``module_area=120``, in a shell ``--module-area 120``.
    """
    return ShellText(f"{name}={value!r}", f"--{name.replace('_', '-')} {value}")


LEAST_SQUARES = argument("method", "least_squares")
UNCHECKED = ShellText("check_units=False (--no-unit-check)", "--no-unit-check")
FIXED = ShellText("fixed", "--fix")


def similar_names(word: str, known: Iterable[object], most: int = 3) -> list[str]:
    """
    Names that a misspelled word may stand for, the nearest first.

    They are the same in other capitals, contain the word, or share most letters.

    Parameters
    ----------
    word : str
    known : iterable of str
    most : int, default 3
        Number of names at most.

    Returns
    -------
    list of str
    """
    names = {str(name): str(name).casefold() for name in known}
    folded = word.casefold()
    near = difflib.get_close_matches(folded, names.values(), most)
    inside = [one for one in names.values() if len(folded) > 2 and folded in one]
    order = list(dict.fromkeys([*near, *inside]))
    matches = [name for name, one in names.items() if one in order]
    return sorted(matches, key=lambda name: order.index(names[name]))[:most]


def did_you_mean(words: str | Iterable[str], known: Iterable[object]) -> str:
    """
    A question behind unknown names in a message; "" if no name is near.

    Parameters
    ----------
    words : str or iterable of str
        The unknown names.
    known : iterable of str

    Returns
    -------
    str
        Such as ``" (did you mean 'Irr [W/m2]'?)"``.
    """
    words, known = [words] if isinstance(words, str) else list(words), list(known)
    near = {word: " or ".join(map(repr, similar_names(word, known))) for word in words}
    near = {word: names for word, names in near.items() if names}
    if not near:
        return ""
    if len(words) == 1:
        return f" (did you mean {near[words[0]]}?)"
    choices = ", and ".join(f"{names} for {word}" for word, names in near.items())
    return f" (did you mean {choices}?)"


def written_argument(value: Any) -> str:
    """
    An argument as Python code, empty for a default.

    Parameters
    ----------
    value : object
        None, True and a dataclass with no changed field are defaults. An object with a
        ``spec``, such as an effect, is written by it.

    Returns
    -------
    str
        Such as ``"Limits(far=8.0)"``; a Series is not written out.
    """
    if value is None or value is True:
        return ""
    if isinstance(value, pd.Series):
        return "...  # True in the rows of the second hash"
    if is_dataclass(value) and not hasattr(value, "spec"):
        usual = type(value)()
        changed = [
            f"{field.name}={getattr(value, field.name)!r}"
            for field in fields(value)
            if getattr(value, field.name) != getattr(usual, field.name)
        ]
        return f"{type(value).__name__}({', '.join(changed)})" if changed else ""
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(written_argument, value))}]"
    return repr(getattr(value, "spec", value))
