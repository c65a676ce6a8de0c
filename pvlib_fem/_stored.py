"""Results in JSON files that keep every bit and are checked when read."""

import json
import math
import os
import secrets
import shutil
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

VERSION = 4  # of the format; it changes when a key changes


@contextmanager
def replacing(path: Any) -> Iterator:
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
    """Return the text, and write it to a path if given, equal on every system."""
    if path is not None:
        with (
            replacing(path) as whole,
            open(whole, "w", encoding="utf-8", newline="\n") as file,
        ):
            file.write(text)
    return text


def written(kind: str, content: dict, path: Any = None) -> str:
    """Return a result as JSON, and write it to a path if given."""
    content = stamped(kind, content)
    text = json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False)
    saved(text + "\n", path)
    return text


def stamped(kind: str, content: dict) -> dict:
    """The content of a file of a kind, with format and version."""
    return plain({"format": kind, "version": VERSION, **content})


def plain(content: Any) -> Any:
    """Content in types of JSON: null for NaN, "inf" for infinity."""
    if isinstance(content, Mapping):
        return {str(key): plain(value) for key, value in content.items()}
    if isinstance(content, list | tuple):
        return [plain(value) for value in content]
    if isinstance(content, np.generic):
        content = content.item()
    if isinstance(content, float) and not math.isfinite(content):
        return None if math.isnan(content) else str(content)
    return content


@contextmanager
def opened(path: Any, kinds: Sequence) -> Iterator:
    """
    Open the content of a file that has one of the formats ``kinds``.

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

    try:
        content = json.loads(
            Path(path).read_text(encoding="utf-8"),
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
        if key not in self.content:
            raise ValueError(f"{self.file} has no {self.place}{key}")
        return self.content[key]

    def of(self, key: str, kind: Any, words: str) -> Any:
        """The value of a key, checked by type."""
        value = self[key]
        # True is an int of Python, and no number
        if not isinstance(value, kind) or (isinstance(value, bool) != (kind is bool)):
            raise ValueError(
                f"{self.file}: {self.place}{key} is {json.dumps(value)[:60]}, where "
                f"{words} belongs"
            )
        return value

    def part(self, key: str) -> "Stored":
        return Stored(self.of(key, dict, "an object"), self.file, f"{self.place}{key}.")

    def parts(self, key: str) -> list:
        """The parts of a list of objects."""
        listed = {str(i): value for i, value in enumerate(self.of(key, list, "a list"))}
        inside = Stored(listed, self.file, f"{self.place}{key}.")
        return [inside.part(i) for i in listed]

    def text(self, key: str) -> str:
        return self.of(key, str, "a text")

    def texts(self, key: str) -> tuple:
        return tuple(map(str, self.of(key, list, "a list")))

    def flag(self, key: str) -> bool:
        return self.of(key, bool, "true or false")

    def count(self, key: str) -> int:
        value = self.of(key, int, "a whole number")
        if value < 0:
            raise ValueError(
                f"{self.file}: {self.place}{key} is {value}, where a count belongs"
            )
        return value

    def number(self, key: str, unknown: bool = False) -> float:
        """A finite number; with ``unknown``, NaN or infinity are allowed, too."""
        if unknown and (self[key] is None or self[key] in ("inf", "-inf")):
            return math.nan if self[key] is None else float(self[key])
        return self.of(key, int | float, "a number")

    def numbers(self, key: str, unknown: bool = False) -> dict:
        """Numbers by name."""
        inside = self.part(key)
        return {name: inside.number(name, unknown) for name in inside.content}

    def pairs(self, key: str) -> dict:
        """Pairs of numbers by name."""
        inside, found = self.part(key), {}
        for name in inside.content:
            pair = dict(zip("01", inside.of(name, list, "a list"), strict=False))
            ends = Stored(pair, self.file, f"{inside.place}{name}.")
            found[name] = (ends.number("0"), ends.number("1"))
        return found
