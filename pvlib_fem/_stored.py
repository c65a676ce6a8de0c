"""Results in JSON files that keep every bit and are checked when read."""

import json
import os
import secrets
import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pvlib_fem._converter import converter, error_in_words
from pvlib_fem._former_names import file_in_new_names

VERSION = 4  # of the format; it changes when a key changes
NEEDED = object()  # in place of the default of a key that has to be there


@contextmanager
def replacing(path: Any) -> Iterator[Path]:
    """
    Write to a temporary file in the same folder and rename it at the end.

    If writing fails, the old file is unchanged. A path that is no regular file, such as
    a pipe, is written to directly.

    Parameters
    ----------
    path : str or path-like

    Yields
    ------
    Path
    """
    path = Path(path)
    if path.exists() and not path.is_file():
        yield path
        return
    path = Path(os.path.realpath(path))  # replace the target of a link, not the link
    whole = path.with_name(f".{path.stem[:40]}.{secrets.token_hex(4)}{path.suffix}")
    try:
        whole.touch(exist_ok=False)
        if path.exists():
            shutil.copymode(path, whole)
        yield whole
        os.replace(whole, path)
    finally:
        whole.unlink(missing_ok=True)


def saved(text: str, path: Any) -> str:
    """
    Return the text, and write it to a path if given, equal on every system.

    Parameters
    ----------
    text : str
    path : str, path-like or None
        Replaced as a whole, in UTF-8 and with line feeds; None writes nothing.

    Returns
    -------
    str
        ``text``, unchanged.
    """
    if path is not None:
        with (
            replacing(path) as whole,
            open(whole, "w", encoding="utf-8", newline="\n") as file,
        ):
            file.write(text)
    return text


def written(kind: str, content: dict, path: Any = None) -> str:
    """
    Return a result as JSON, and write it to a path if given.

    Parameters
    ----------
    kind : str
        Format of the file, such as ``"pvlib_fem.FemFit"``.
    content : dict
        Fields of the result, as Python has them; see :func:`as_json`.
    path : str or path-like, optional
        None writes nothing.

    Returns
    -------
    str
        JSON text; the file has a line end behind it.
    """
    content = stamped(kind, content)
    text = json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False)
    saved(text + "\n", path)
    return text


def stamped(kind: str, content: dict) -> dict:
    """
    Content of a file of a kind, with format and version.

    Parameters
    ----------
    kind : str
        Format of the file.
    content : dict
        Fields of the result.

    Returns
    -------
    dict
        In types of JSON, with ``format`` and ``version`` first.
    """
    return as_json({"format": kind, "version": VERSION, **content})


def as_json(content: Any) -> Any:
    """
    Convert a result, or other content of a file, to types of JSON.

    Parameters
    ----------
    content : object
        A dataclass, dict, list, tuple, time or number, also nested.

    Returns
    -------
    dict, list, str, float, int, bool or None
        NaN is None, an infinity ``"inf"`` or ``"-inf"``.
    """
    return converter().unstructure(content)


@contextmanager
def opened(path: Any, kinds: Sequence) -> Iterator["Stored"]:
    """
    Open the content of a file that has one of some formats.

    Parameters
    ----------
    path : str or path-like
    kinds : sequence of str
        Formats that are accepted.

    Yields
    ------
    Stored

    Raises
    ------
    ValueError
        If it is no JSON, of another kind or of another version; or, inside, if
        something in it is not what ``to_json`` writes.
    """
    content = content_of(path, kinds)
    try:
        yield Stored(content, str(path))
    except ValueError as error:
        if str(path) in str(error):
            raise
        raise ValueError(f"{path}: {error}") from error
    except (KeyError, TypeError, AttributeError, IndexError) as error:
        raise ValueError(
            f"{path} holds what no to_json wrote: {type(error).__name__}, {error}"
        ) from error


def content_of(path: Path, kinds: Sequence) -> dict:
    """The JSON object of a file, checked by format and version."""

    def refused(constant: Any) -> None:
        raise ValueError(f"{path} holds {constant}, which is no number of JSON")

    def once(pairs: list) -> dict:
        names = [name for name, _ in pairs]
        if twice := {name for name in names if names.count(name) > 1}:
            raise ValueError(f"{path} holds {min(twice)} twice in one object")
        return dict(pairs)

    if isinstance(path, str) and path.startswith("{\n"):
        raise ValueError(
            "path is the text of a result, as to_json() returns it; write it to a "
            "file with to_json(path), and give its path"
        )
    try:
        content = json.loads(
            file_in_new_names(Path(path).read_text(encoding="utf-8")),
            parse_constant=refused,
            object_pairs_hook=once,
        )
    except (json.JSONDecodeError, UnicodeDecodeError) as error:
        raise ValueError(f"{path} is no JSON: {error}") from error
    except RecursionError as error:
        raise ValueError(f"{path} is nested deeper than any to_json writes") from error
    content = content if isinstance(content, dict) else {}
    if content.get("format") not in kinds:
        raise ValueError(
            f"{path} is no file of {' or '.join(kinds)} (its format is "
            f"{content.get('format', 'not said')}); write one with to_json"
        )
    if content.get("version") != VERSION:
        raise ValueError(
            f"{path} is of version {content.get('version')} of its format, and this "
            f"pvlib_fem reads version {VERSION}; fit again and write it with to_json, "
            "or take the pvlib_fem that wrote it"
        )
    return content


@dataclass(frozen=True)
class Stored:
    """A part of a file; errors name the missing or wrong key."""

    content: dict
    file: str
    place: str = ""

    def __getitem__(self, key: str) -> Any:
        return self.read(key, Any)

    def read(self, key: str, kind: Any, default: Any = NEEDED) -> Any:
        """
        The value of a key as an object of a type.

        Parameters
        ----------
        key : str
        kind : type
            A class of results, or another type that :func:`converter` reads.
        default : optional
            Value if there is no such key.

        Raises
        ------
        ValueError
            If there is no such key, or a value is of another type.
        """
        if key in self.content:
            return self.converted(self.content[key], kind, f"{key}.")
        if default is NEEDED:
            raise ValueError(f"{self.file} has no {self.place}{key}")
        return default

    def whole(self, kind: Any) -> Any:
        """The part itself as an object of a type."""
        return self.converted(self.content, kind, "")

    def converted(self, value: Any, kind: Any, place: str) -> Any:
        try:
            return converter().structure(value, kind)
        except Exception as error:
            place = f"{self.place}{place}"
            raise ValueError(error_in_words(error, self.file, place)) from error

    def part(self, key: str) -> "Stored":
        return Stored(self.read(key, dict), self.file, f"{self.place}{key}.")

    def parts(self, key: str) -> list["Stored"]:
        """The parts of a list of objects."""
        items = enumerate(self.read(key, list[dict]))
        return [Stored(one, self.file, f"{self.place}{key}.{i}.") for i, one in items]
