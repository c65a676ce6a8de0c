"""The page that a study makes."""

import platform
import subprocess
from datetime import date
from importlib.metadata import version
from pathlib import Path

LIBRARIES = "pvlib", "numpy", "scipy", "pandas"  # of which results could depend


def publish(text, out=None, command="", libraries=LIBRARIES):
    """
    Write a page, or print it where there is no path.

    Parameters
    ----------
    text : str
        Markdown, whose first line is the title.
    out : pathlib.Path, optional
    command : str, optional
        Command that makes the page. With it the line after the title says when it was
        made, with which commit and which versions.
    libraries : iterable of str
        Distributions whose versions are stated.
    """
    if command:
        title, rest = text.split("\n", 1)
        text = f"{title}\n\n{made_by(command, libraries)}\n\n{rest.lstrip()}"
    if out is None:
        print(text)
    else:
        out.write_text(text.rstrip("\n") + "\n", encoding="utf-8", newline="\n")


def made_by(command, libraries=LIBRARIES):
    """State the command, the date, the commit and the versions of libraries."""
    used = ", ".join(f"{name} {version(name)}" for name in libraries)
    return (
        f"Made by `{command}` on {date.today()}: pvlib_fem at commit {commit()},\n"
        f"{used}, Python {platform.python_version()}."
    )


def commit():
    """Abbreviated hash of the commit that is checked out."""
    how = ["git", "rev-parse", "--short=7", "HEAD"]
    root = Path(__file__).parent
    return subprocess.run(
        how, cwd=root, capture_output=True, text=True, check=True
    ).stdout.strip()
