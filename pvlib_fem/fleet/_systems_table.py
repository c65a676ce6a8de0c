"""The table of systems: files of each system, how to read them, and its site."""

import difflib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem._record.column_names import ROTATION, renamed
from pvlib_fem._record.file_times import zoned
from pvlib_fem._record.header_units import QUANTITIES, unit_of
from pvlib_fem._record.layout import EXCEL, PARQUET, SKIP_LINES, Layout, layout_of
from pvlib_fem._thermal.steady_models import steady_model
from pvlib_fem.drivers._mounts import ANGLES, TRACKER
from pvlib_fem.types import FilePath

#: numbers of a place, with their ranges
PLACE = {
    "latitude": (-90.0, 90.0),
    "longitude": (-180.0, 180.0),
    "surface_tilt": (0.0, 180.0),
    "surface_azimuth": (-360.0, 360.0),
}
#: options of reading in addition to the layout of the file
READING = ("convert_units", "check_units", "module_area")
LAYOUT = (*(one.name for one in fields(Layout)), SKIP_LINES)
UNITS = {f"{name}_unit": name for name in QUANTITIES}
#: cells with the names of a file's columns: of angles, those that are no numbers
CELLS = {name: name for name in (*QUANTITIES, ROTATION)}
CELLS |= {name: f"{name}_column" for name in ANGLES}
KNOWN = (
    "id",
    "file",
    "site",
    "pdc0",
    "steady_model",
    *PLACE,
    *TRACKER,
    "backtrack",
    *LAYOUT,
    *READING,
    *CELLS.values(),
    *UNITS,
)
#: names of the command's options, and usual ones, for those of a table
MEANT = {
    "lat": "latitude",
    "lon": "longitude",
    "long": "longitude",
    "lng": "longitude",
    "tilt": "surface_tilt",
    "azimuth": "surface_azimuth",
}
BETWEEN = "|"  # separates files of several loggers, and texts of one cell
TRUE, FALSE = ("true", "yes", "1"), ("false", "no", "0")


@dataclass(frozen=True)
class System:
    """
    A row of the table, checked.

    Attributes
    ----------
    id : str
    files : tuple of str
        Path, pattern or URL of each logger; a pattern matches the pieces of its record.
    columns, units : dict
        Columns of the file and their units, by the package's names.
    layout : dict
        Arguments of :func:`pvlib_fem._record.layout.layout_of`.
    reading : dict
        ``convert_units``, ``check_units``, ``module_area``.
    place : dict
        ``latitude``, ``longitude``, ``surface_tilt``, ``surface_azimuth``, if known.
        [°]
    tracker : dict
        ``axis_tilt``, ``axis_azimuth``, ``max_angle`` [°], ``gcr`` and ``backtrack`` of
        a tracker, as far as they are given.
    pdc0 : float
        Nominal power, NaN if unknown. [W]
    labels : dict
        All other columns, ``site`` first.
    steady_model : str
        Steady model of this system; "" for that of the run.
    """

    id: str
    files: tuple[str, ...]
    columns: dict[str, str]
    units: dict[str, str]
    layout: dict[str, Any]
    reading: dict[str, Any]
    place: dict[str, float]
    pdc0: float
    labels: dict[str, str]
    steady_model: str = ""
    tracker: dict[str, Any] = field(default_factory=dict)


def opened_table(systems: pd.DataFrame | FilePath) -> pd.DataFrame:
    """
    The table as text and numbers, in the order of its ids.

    Parameters
    ----------
    systems : DataFrame, str or path-like
        A table, or a CSV, Excel or Parquet file; paths in it start at its folder.

    Returns
    -------
    DataFrame
        ``attrs["folder"]`` is the folder at which relative paths start.

    Raises
    ------
    ValueError
        If the file is no table, a required column is missing, an id comes twice, or a
        column looks like a misspelled known one.
    """
    folder = Path.cwd()
    if isinstance(systems, pd.DataFrame):
        table = systems.copy()
    else:
        folder = Path(systems).resolve().parent
        try:
            table = table_of_file(Path(systems))
        except ValueError as error:
            raise ValueError(
                f"{systems} is no table of systems ({error}); save it as Parquet, "
                "Excel or CSV, in UTF-8 and with commas"
            ) from error
    table.columns = [str(name).strip() for name in table.columns]
    for name in ("id", "file"):
        if name not in table:
            raise ValueError(
                f"the table of systems has no column {name!r}; it has "
                f"{', '.join(table.columns)}"
            )
    for new, old in renamed(table.columns).items():
        table = table.rename(columns={old: new, f"{old}_unit": f"{new}_unit"})
    for name in table.columns:
        alike = difflib.get_close_matches(name.lower(), KNOWN, 1, 0.85)
        alike = [MEANT[name.lower()]] if name.lower() in MEANT else alike
        if name not in KNOWN and alike and alike[0] not in table:
            raise ValueError(
                f"the table of systems has a column {name!r}, which looks like "
                f"{alike[0]!r}; call it that, or otherwise if it is a label"
            )
    if table.columns.duplicated().any():
        twice = table.columns[table.columns.duplicated()][0]
        raise ValueError(f"the table of systems has the column {twice!r} twice")
    if len(table) == 0:
        raise ValueError("the table of systems has no row")
    ids = table["id"].map(
        lambda value: "" if is_empty_cell(value) else str(value).strip()
    )
    if (ids == "").any():
        row = int((ids == "").to_numpy().argmax())
        raise ValueError(f"the system in row {row} has no id; give each one its own")
    if ids.duplicated().any():
        twice = ids[ids.duplicated()].iloc[0]
        raise ValueError(f"the id {twice!r} comes twice; give each system its own")
    table = table.assign(id=ids).sort_values("id", kind="stable", ignore_index=True)
    table.attrs = {"folder": str(folder)}
    return table


def table_of_file(path: Path) -> pd.DataFrame:
    """The table of a CSV, Excel or Parquet file; NA is a name such as a region's."""
    if (suffix := path.suffix.lower()) in PARQUET:
        return pd.read_parquet(path)
    read = pd.read_excel if suffix in EXCEL else pd.read_csv
    empty = ["", "NaN", "nan"]
    return read(path, dtype=str, keep_default_na=False, na_values=empty)


def systems_of(table: pd.DataFrame) -> Iterator[System]:
    """
    Yield the systems of an :func:`opened` table.

    Parameters
    ----------
    table : DataFrame
        A row for each system; ``attrs["folder"]`` is the folder of relative paths.

    Yields
    ------
    System
        In the order of the rows.

    Raises
    ------
    ValueError
        If a row is wrong, with the id of its system.
    """
    names, folder = list(table.columns), table.attrs["folder"]
    labels = labels_of(table)
    for values in table.itertuples(index=False, name=None):
        row = {n: v for n, v in zip(names, values) if not is_empty_cell(v)}
        try:
            yield system_of(row, labels, folder)
        except ValueError as error:
            raise ValueError(f"system {row['id']}: {error}") from error


def labels_of(table: pd.DataFrame) -> list[str]:
    """
    Names of the label columns, the site first.

    Parameters
    ----------
    table : DataFrame
        A row for each system.

    Returns
    -------
    list of str
        ``"site"``, also without such a column, and all columns without a meaning of
        their own.
    """
    return ["site", *(name for name in table.columns if name not in KNOWN)]


def system_of(row: Mapping[str, Any], labels: Iterable[str], folder: str) -> System:
    """A system, from the cells of its row that are not empty."""
    if "file" not in row:
        raise ValueError("it has no file")
    place, tracker = (
        {
            name: cell_number(row[name], name, *ends)
            for name, ends in some
            if name in row
        }
        for some in (PLACE.items(), TRACKER.items())
    )
    if "backtrack" in row:
        tracker["backtrack"] = cell_flag(row["backtrack"], "backtrack")
    if tracker and "surface_tilt" in place:
        raise ValueError(
            f"it has surface_tilt and {min(tracker)}; leave out the one of a fixed "
            "plane or that of a tracker"
        )
    if tracker and "latitude" not in place:
        raise ValueError(f"it has {min(tracker)} and no latitude")
    for pair in (("latitude", "longitude"), ("surface_tilt", "surface_azimuth")):
        given = [name for name in pair if name in place]
        if len(given) == 1:
            (other,) = {*pair} - {*given}
            raise ValueError(f"it has {given[0]} and no {other}")
    layout: dict[str, Any] = {
        name: layout_field(name, row[name]) for name in LAYOUT if name in row
    }
    layout_of(layout)  # refuses skip_rows together with skip_lines
    if "tz" in layout:
        zoned(pd.DatetimeIndex([]), layout["tz"])  # refuses an unknown zone
    reading: dict[str, Any] = {
        name: cell_flag(row[name], name) for name in READING[:2] if name in row
    }
    if "module_area" in row:
        reading["module_area"] = cell_number(row["module_area"], "module_area", 0.0)
    model = str(row.get("steady_model", "")).strip()
    if model:
        steady_model(model)  # refuses an unknown model
    units = {
        quantity: str(row[name]).strip()
        for name, quantity in UNITS.items()
        if name in row
    }
    return System(
        id=row["id"],
        files=tuple(absolute_path(file, folder) for file in cell_texts(row["file"])),
        columns={name: str(row[cell]) for name, cell in CELLS.items() if cell in row},
        units={name: unit_of(name, unit) for name, unit in units.items()},
        layout=layout,
        reading=reading,
        place=place,
        pdc0=cell_number(row.get("pdc0", np.nan), "pdc0", 0.0),
        labels={name: str(row.get(name, "")) for name in labels},
        steady_model=model,
        tracker=tracker,
    )


def is_empty_cell(value: Any) -> bool:
    """Whether a cell is empty."""
    if value is None or (isinstance(value, str) and not value.strip()):
        return True
    return bool(np.ndim(value) == 0 and pd.isna(value))


def cell_texts(value: Any) -> list[str]:
    """The texts of a cell."""
    if isinstance(value, str):
        return [part.strip() for part in value.split(BETWEEN)]
    return [str(value)] if np.ndim(value) == 0 else [str(part) for part in value]


def absolute_path(file: str, folder: str) -> str:
    """An absolute path; a URL is returned as it is."""
    return file if "://" in file or "::" in file else str(Path(folder, file))


def cell_number(
    value: Any, name: str, least: float = -np.inf, most: float = np.inf
) -> float:
    """The number of a cell, checked by its range."""
    try:
        parsed = float(value)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{name} is {value!r}; it has to be a number") from error
    if not (least <= parsed <= most or np.isnan(parsed)):
        raise ValueError(f"{name} is {parsed:g}; it is {least:g} to {most:g}")
    return parsed


def cell_flag(value: Any, name: str) -> bool:
    """The boolean of a cell."""
    word = str(value).strip().lower().removesuffix(".0")
    if word not in TRUE + FALSE:
        raise ValueError(f"{name} is {value!r}; it has to be true or false")
    return word in TRUE


def layout_field(name: str, value: Any) -> str | bool | int | tuple:
    """A field of the layout, from its cell."""
    if name in ("time", "missing", "keep"):
        return tuple(cell_texts(value))
    if name in ("sort", "drop_doubled", "drop_untimed"):
        return cell_flag(value, name)
    lines = str(value)
    if name == SKIP_LINES or (name == "skip_rows" and "," in lines):
        return tuple(int(cell_number(n, name, 0)) for n in lines.strip(", ").split(","))
    if name in ("skip_rows", "skip_end", "header_rows"):
        return int(cell_number(value, name, int(name == "header_rows")))
    return "\t" if value == r"\t" else str(value)
