"""Options of a file: its columns, times and layout."""

import glob
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from pvlib_fem._cli.headings import COLUMNS, LAYOUT, TIMES, option_maker, with_options
from pvlib_fem._record.column_names import COLUMNS as USUAL

column, times, layout = option_maker(COLUMNS), option_maker(TIMES), option_maker(LAYOUT)


class Readable(click.Path):
    """A file or a folder that is there, or a pattern of files."""

    def convert(
        self,
        value: str | os.PathLike[str],
        param: click.Parameter | None,
        ctx: click.Context | None,
    ) -> Any:
        if glob.has_magic(str(value)) and not Path(value).exists():
            return Path(value)
        return super().convert(value, param, ctx)


def files_argument(required: bool = True) -> Callable:
    """
    Argument of a command for files, folders and patterns.

    Parameters
    ----------
    required : bool, default True
        Whether the command needs at least one.

    Returns
    -------
    callable
        Decorator of a command, which gets ``files``, a tuple of Path.
    """
    return click.argument(
        "files",
        metavar="FILE..." if required else "[FILE...]",
        nargs=-1,
        required=required,
        type=Readable(exists=True, path_type=Path),
    )


layout_options = with_options(
    column(
        "--guess",
        is_flag=True,
        help="Propose a command for these files, and run nothing.",
    ),
    column(
        "--map",
        "renames",
        multiple=True,
        metavar="NAME=COLUMN",
        help=f"Column of the file that is {', '.join(USUAL)} or another that the "
        "command knows; once for each.",
    ),
    times(
        "--time",
        multiple=True,
        metavar="COLUMN",
        help="Column of the times, or those of their parts, as Date,Time or Year,Month,"
        "Day,Hour,Minute; by default the first.",
    ),
    times(
        "--time-format",
        multiple=True,
        help="Format of the times, such as '%d/%m/%Y %H:%M', or unix, unix-ms, "
        "excel or matlab for times that are counted; by default ISO 8601.",
    ),
    layout(
        "--tag",
        multiple=True,
        metavar="COLUMN",
        help="Of a table with a row for each reading: the column of what is read, of "
        "which each becomes a column.",
    ),
    layout(
        "--value",
        multiple=True,
        metavar="COLUMN",
        help="Of such a table: the column of the readings.",
    ),
    times(
        "--tz",
        multiple=True,
        help="Zone of the times, such as Europe/Brussels or Etc/GMT+7.",
    ),
    layout("--sep", multiple=True, help="Between CSV columns, by default ','."),
    layout("--decimal", multiple=True, help="In CSV numbers, by default '.'."),
    layout(
        "--thousands",
        multiple=True,
        metavar="SIGN",
        help="Between the thousands of numbers, by default none.",
    ),
    layout("--encoding", multiple=True, help="Of CSV, by default utf-8."),
    layout(
        "--skip-rows",
        multiple=True,
        metavar="N",
        help="How many lines stand before the header.",
    ),
    layout(
        "--skip-lines",
        multiple=True,
        metavar="N,N,…",
        help="Lines to leave out, of which the first is 0: 1 for a line of units below "
        "the header, 0,2,3 for a TOA5 file.",
    ),
    layout(
        "--header-rows",
        multiple=True,
        metavar="N",
        type=click.IntRange(min=1),
        help="How many lines the header has, whose labels are joined.",
    ),
    layout(
        "--skip-end",
        multiple=True,
        metavar="N",
        type=click.IntRange(min=0),
        help="How many lines stand after the last row, such as totals.",
    ),
    layout("--sheet", multiple=True, help="Of a workbook, by default the first."),
    layout(
        "--missing",
        multiple=True,
        metavar="TEXT",
        help="Text that stands for a missing value, such as ---; once for each.",
    ),
    layout(
        "--keep",
        multiple=True,
        metavar="COLUMN=TEXT",
        help="Leave out rows without this text in a column, such as Quality=Good; once "
        "for each text.",
    ),
    times("--sort", is_flag=True, help="Put the rows in the order of their times."),
    times(
        "--drop-doubled",
        is_flag=True,
        help="Of rows with the same time keep the first.",
    ),
    times(
        "--drop-untimed",
        is_flag=True,
        help="Leave out rows that hold no time, such as a header within the file.",
    ),
    column(
        "--convert",
        is_flag=True,
        help="Convert columns whose headers name another unit, such as (mph).",
    ),
    column(
        "--unit",
        "units",
        multiple=True,
        metavar="NAME=UNIT",
        help="Unit of a column that is to be converted, such as wind_speed=km/h; once "
        "for each.",
    ),
    column(
        "--module-area",
        type=click.FloatRange(min=0, min_open=True),
        help="Area of the modules whose power p_dc_per_area is in W, kW or MW [m²].",
    ),
    column(
        "--no-unit-check",
        is_flag=True,
        help="Accept columns that look to be in another unit.",
    ),
)
reading_options = with_options(files_argument(), layout_options)
