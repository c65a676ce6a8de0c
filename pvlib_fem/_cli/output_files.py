"""What is written: nothing that is read, and nothing that cannot be."""

from collections.abc import Callable, Iterable
from importlib.util import find_spec
from pathlib import Path

import pandas as pd

from pvlib_fem._cli.printing import say
from pvlib_fem._fitting.fem_fit import FemFit
from pvlib_fem._loop.results.loop_result import Loop
from pvlib_fem._stored import replacing
from pvlib_fem.plotting._style import check_format

#: option: what it writes, and the endings of its file
ENDINGS = {
    "report": ("a page", (".html", ".htm")),
    "out": ("JSON", (".json",)),
    "common": ("a table", (".csv",)),
    "corrected": ("a table", (".csv",)),
    "cleaned": ("a table", (".csv",)),
    "csv": ("a table", (".csv",)),
}
FORMULA = ("=", "+", "-", "@")  # with which a formula begins


def check_outputs(
    read: Iterable[Path] = (),
    made: Iterable[Path] = (),
    pictures: bool = True,
    **written: Path | None,
) -> None:
    """
    Refuse before the work what cannot be written after it, or would destroy a file.

    Parameters
    ----------
    read : sequence of Path
        Files that are read.
    made : sequence of Path
        Folders that the work makes.
    pictures : bool, default True
        Whether a report has pictures.
    **written : Path or None
        By the name of the option.
    """
    drawn = written.get("plot") or (pictures and written.get("report"))
    if drawn and find_spec("matplotlib") is None:
        raise ValueError(
            "a picture or a report needs matplotlib: pip install 'pvlib_fem[plot]'"
        )
    taken = {file_identity(path): f"{path.name} is read" for path in read}
    for name, path in written.items():
        if path is None:
            continue
        folder = path.absolute().parent
        if not folder.is_dir() and folder not in {one.absolute() for one in made}:
            raise ValueError(f"there is no folder {path.parent} for {path.name}")
        if (place := file_identity(path)) in taken:
            raise ValueError(
                f"--{name} {path} would overwrite a file: {taken[place]}; give it "
                "another name"
            )
        taken[place] = f"--{name} writes it, too"
        if name == "plot":
            check_format(path)
        elif path.suffix.lower() not in ENDINGS[name][1]:
            what, endings = ENDINGS[name]
            raise ValueError(
                f"--{name} writes {what}, so {path.name} has to end with {endings[0]}"
            )


def check_ceiling(wanted: bool) -> None:
    """
    Refuse before the work what needs a package that is missing.

    Parameters
    ----------
    wanted : bool
        Whether the ceiling has to be computed.

    Raises
    ------
    ValueError
        If scikit-learn is not installed.
    """
    if wanted and find_spec("sklearn") is None:
        raise ValueError(
            "--ceiling needs scikit-learn: pip install 'pvlib_fem[ceiling]'"
        )


def file_identity(path: Path) -> str | tuple[int, int]:
    """One name for one file, through links and on systems without capitals."""
    path = Path(path).resolve()
    if path.exists():
        status = path.stat()
        if status.st_ino:
            return status.st_dev, status.st_ino
    return str(path).casefold()


def write(path: Path | None, writer: Callable[[Path], object]) -> None:
    """
    Write a file, and say so.

    Parameters
    ----------
    path : Path or None
        Without a path nothing is written.
    writer : callable
        Writes the file; takes the path.
    """
    if path is not None:
        writer(path)
        say(f"\nwrote {path}")


def as_csv(frame: pd.DataFrame) -> str:
    """
    A frame as CSV, in whose header a spreadsheet finds no formula.

    A name that begins as a formula does gets an apostrophe before it, as a spreadsheet
    has it for text.

    Parameters
    ----------
    frame : DataFrame
        Its index is the first column of the text.

    Returns
    -------
    str
    """
    return frame.rename(
        columns=lambda name: f"'{name}" if str(name).lstrip()[:1] in FORMULA else name
    ).to_csv()


def write_picture(result: FemFit, path: Path) -> None:
    """
    Write the picture of a fit, in the format that its name ends with.

    Parameters
    ----------
    result : FemFit
        Fit to draw.
    path : Path
        File ``.png``, ``.svg`` or ``.pdf``.
    """
    figure = result.plot().figure
    with replacing(path) as whole:
        figure.savefig(whole, dpi=150, format=path.suffix[1:].lower())


def write_report(
    path: Path | None, result: FemFit | Loop, title: str | None, files: Iterable[Path]
) -> None:
    """
    Write the page of a fit or a loop, and say so.

    Parameters
    ----------
    path : Path or None
        Without a path nothing is written.
    result : FemFit or Loop
        Result to report.
    title : str or None
        Title of the page; by default the names of the files.
    files : iterable of Path
        Files of the record.
    """
    title = title or ", ".join(file.name for file in files)
    write(path, lambda whole: result.to_html(whole, title=title))
