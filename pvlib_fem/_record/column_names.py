"""Columns by their names: which are there, and which can be used."""

import re
import unicodedata
import warnings
from collections.abc import Hashable, Iterator, Mapping
from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem._spelling import ShellText, no_columns, refusal
from pvlib_fem.reasons import Because, Reason, because

#: what every record needs
COLUMNS = ("poa_global", "temp_air", "wind_speed", "temp_module")
#: those of them that none is without: some models need no wind
ALWAYS = ("poa_global", "temp_air", "temp_module")
DAYLIGHT = 20.0  # W/m², above which it is day
#: units of the columns under pvlib's names
UNITS = {
    "poa_global": "W/m²",
    "ghi": "W/m²",
    "dni": "W/m²",
    "dhi": "W/m²",
    "poa_rear": "W/m²",
    "temp_air": "°C",
    "temp_module": "°C",
    "temp_cell": "°C",
    "wind_speed": "m/s",
    "wind_direction": "° from north",
    "relative_humidity": "%",
    "longwave_down": "W/m²",
    "ir_down": "W/m²",
    "precipitation": "mm/h",
    "snow_depth": "cm",
    "p_dc_per_area": "W/m²",
    "power_dc": "W",
    "power_ac": "W",
    "solar_zenith": "°",
    "solar_azimuth": "°",
    "residual": "K",
}
#: where the sun stands and how the module does, under pvlib's names [°]
GEOMETRY = ("solar_zenith", "solar_azimuth", "surface_tilt", "surface_azimuth")
#: rotation of a tracker about its axis, under pvlib's name [°]
ROTATION = "tracker_theta"
ANGLES = ("wind_direction", "solar_azimuth", "surface_azimuth")  # of a full circle
#: other names that pvlib has for a column
ALIASES = {"ir_down": "longwave_down"}
#: names of 0.1 before its release, which 0.2 will not know
RENAMED = {"p_dc": "p_dc_per_area"}
#: in the ``attrs`` of data: columns whose unit a header or the user states
STATED = "stated"
ORIGINAL = "_original"  # after the name of a column as it was before a correction
FEW = 4000  # rows that show that two are no copies
COMPARED = ShellText(
    "compare_modules(data).common has what they have in common",
    "pvlib-fem modules FILE --common NEW.csv writes what they have in common",
)


TRANSPOSED = ShellText(
    "transpose_record(data, location, surface_tilt, surface_azimuth)",
    "--transposition perez",
)
SERVED = ("temp_air", "wind_speed")  # for which a second source can stand in
#: power of a plant, the better column first
PLANT_POWER = ("power_dc", "p_dc_per_area", "power_ac")
#: names of power, and of a second sensor
POWER = re.compile(r"(power|p)_(ac|dc|mp|mpp)(_\w+)?|power(_\w+)?")
#: light in the plane that is no second sensor of all light on the front
OTHER_LIGHT = re.compile(r"poa_(rear|direct|beam|diffuse|(sky|ground)_diffuse)(_\w+)?")
TWIN = re.compile(r"(poa|poa_global|temp_air|wind_speed|temp_module)_\w+")


def twin_of(name: Hashable) -> str | None:
    """
    The usual column of which one is a second sensor, by its name.

    Parameters
    ----------
    name : hashable
        Label of a column.

    Returns
    -------
    str or None
        Such as ``"temp_module"`` of ``"temp_module_2"``; None of any other name, of the
        usual columns themselves, of ``poa_rear`` and parts of the light such as
        ``poa_diffuse``, and of names that end with ``_original``.
    """
    match = TWIN.fullmatch(str(name))
    own = name in COLUMNS or is_other_light(name)
    if match is None or own or str(name).endswith(ORIGINAL):
        return None
    return "poa_global" if match[1] == "poa" else match[1]


def is_state(name: str) -> bool:
    """
    Whether a column holds at its time, and has no mean that stands for it.

    Parameters
    ----------
    name : str
        Package's name.

    Returns
    -------
    bool
        True of temperatures of modules, and of the angles of a plane.
    """
    module = name == COLUMNS[3] or twin_of(name) == COLUMNS[3]
    return module or name in (*GEOMETRY[2:], ROTATION)


def is_other_light(name: Hashable) -> bool:
    """
    Whether a column is a part of the light in the plane, or light on the rear side.

    Parameters
    ----------
    name : hashable
        Label of a column.

    Returns
    -------
    bool
        True for ``poa_rear_2`` or ``poa_diffuse``; False if the name ends with
        ``_original``.
    """
    text = str(name)
    return OTHER_LIGHT.fullmatch(text) is not None and not text.endswith(ORIGINAL)


def is_power(name: str) -> bool:
    """
    Whether a column is power, by its name.

    Parameters
    ----------
    name : str

    Returns
    -------
    bool
        True also for ``p_dc_per_area``; False if the name ends with ``_original``.
    """
    return POWER.fullmatch(str(name)) is not None and not str(name).endswith(ORIGINAL)


def kind_of_power(name: str) -> str:
    """
    End of the names of drivers that are computed from a column of power.

    Parameters
    ----------
    name : str
        In :data:`PLANT_POWER`.

    Returns
    -------
    str
        ``"_dc"``, ``"_ac"`` or ``"_dc_per_area"``.
    """
    return name.removeprefix("power").removeprefix("p")


def known_values(name: str, values: np.ndarray, poa_global: np.ndarray) -> np.ndarray:
    """
    Known rows of a column: missing power without light is 0.

    Parameters
    ----------
    name : str
        Of the column.
    values, poa_global : array, shape (rows,)
        In the column's unit, and [W/m²].

    Returns
    -------
    array of bool, shape (rows,)
    """
    known = np.isfinite(values)
    return known | (poa_global <= DAYLIGHT) if name in PLANT_POWER else known


def plant_power(record: Any, most: float) -> dict[str, pd.Series]:
    """
    Columns of a plant's power that are there by day, which effects may follow.

    Parameters
    ----------
    record : Record
    most : float
        Share of the rows by day that may have no value. [-]

    Returns
    -------
    dict of Series
        By name, the better column first. [W]
    """
    powers, light = {}, record["poa_global"] > DAYLIGHT
    for name in PLANT_POWER:
        if name in record.inputs.columns and light.any():
            values = record[name]
            missing = np.isnan(values[light]).mean()
            if missing <= most and np.nanmax(values) > np.nanmin(values):
                powers[name] = pd.Series(values, record.index)
    return powers


def doubts_of_power(record: Any, most: float) -> Iterator[str]:
    """
    Why columns of a plant's power show no outage and no cover.

    Parameters
    ----------
    record : Record
    most : float
        Share of the rows by day that may have no value. [-]

    Yields
    ------
    str
    """
    light = record["poa_global"] > DAYLIGHT
    for name in PLANT_POWER if light.any() else ():
        if name not in record.inputs.columns:
            continue
        values = record[name][light]
        missing, known = np.isnan(values).mean(), values[~np.isnan(values)]
        if missing > most:
            yield (
                f"{100.0 * missing:.0f} % of {name} by day is missing, so that it "
                "shows no outage and no cover"
            )
        elif known.min() == known.max():
            yield (
                f"{name} is {known[0]:g} at all hours of the day, so that it shows no "
                "outage and no cover"
            )
        elif np.median(known) < 0.0:
            yield (
                f"{name} is {np.median(known):.3g} by day (median): turn its sign, so "
                "that it shows outages and covers"
            )


def is_cross_check(name: str) -> bool:
    """
    Whether a column cross-checks an instrument and drives no effect itself.

    It measures the same quantity as the instrument, or it is a power.

    Parameters
    ----------
    name : str

    Returns
    -------
    bool
    """
    return twin_of(name) is not None or (is_power(name) and name != "p_dc_per_area")


def printable(text: Any, kept: str = "") -> str:
    """
    Text, such as a column's name, that a terminal or a page only shows.

    Parameters
    ----------
    text : object
        Its ``str`` is taken.
    kept : str, default ""
        Signs that stay, such as the end of a line.

    Returns
    -------
    str
        Each sign that :func:`steers` is replaced by ``�``.
    """
    return "".join("�" if steers(c) and c not in kept else c for c in str(text))


def steers(sign: str) -> bool:
    """
    Whether a sign is not for reading: control, direction, half of a pair.

    Parameters
    ----------
    sign : str
        One character.

    Returns
    -------
    bool
    """
    return unicodedata.category(sign) in ("Cc", "Cf", "Cs", "Zl", "Zp")


def with_aliases(data: pd.DataFrame, needed: Any = COLUMNS) -> dict:
    """
    Columns of a frame by the package's names, with those that are needed.

    Parameters
    ----------
    data : DataFrame
    needed : sequence of str, default COLUMNS
        Columns that have to be there, by the package's names.

    Returns
    -------
    dict of Series
        All columns of ``data``; those of objects as numbers where all cells are.

    Raises
    ------
    ValueError
        If ``data`` is no DataFrame, a name comes twice or a needed column is not there.
    """
    refuse_no_frame(data)
    names = [printable(name) for name in data]
    if twice := [name for i, name in enumerate(names) if name in names[:i]]:
        raise ValueError(f"{twice[0]} is there twice; keep one column of each name")
    columns = {name: as_numbers(data[label]) for name, label in zip(names, data)}
    if STATED in data.attrs:
        columns = {name: column.copy(deep=False) for name, column in columns.items()}
        for column in columns.values():
            column.attrs[STATED] = data.attrs[STATED]
    columns = in_new_names(columns)
    for alias, name in ALIASES.items():
        if alias in columns:
            columns.setdefault(name, columns.pop(alias))
    if missing := [name for name in needed if name not in columns]:
        words = f"{no_columns(missing)}; they have {', '.join(columns)}"
        raise refusal(words, *of_others(missing, columns), *of_several(columns))
    return columns


def refuse_no_frame(data: Any) -> None:
    """
    Refuse data that are no DataFrame.

    Parameters
    ----------
    data : object

    Raises
    ------
    ValueError
        With the type that they have.
    """
    if not isinstance(data, pd.DataFrame):
        raise ValueError(
            f"data is a {type(data).__name__}; give a DataFrame with a column of each "
            "name"
        )


def of_horizontal(missing: list, columns: dict) -> Iterator[str | ShellText]:
    """
    What a refusal adds where ``poa_global`` can be made of ``ghi``.

    Parameters
    ----------
    missing : list of str
        Needed columns that are not there.
    columns : dict
        Columns that are there, by name.

    Yields
    ------
    str or ShellText
        Parts of :func:`pvlib_fem._spelling.refusal`; none without ``ghi``.
    """
    if "poa_global" in missing and "ghi" in columns:
        yield "; to make poa_global of ghi, "
        yield TRANSPOSED


def of_others(missing: list, columns: dict) -> Iterator[str | ShellText]:
    """What a refusal adds where missing columns can be made of others."""
    yield from of_horizontal(missing, columns)
    for name in missing:
        others = [other for other in columns if twin_of(other) == name]
        if name in SERVED and others:
            yield f"; to take {others[0]} for {name}, "
            yield filled_from(others[0])


def filled_from(name: str) -> ShellText:
    """
    The step by which a second source replaces the usual one, as text.

    Parameters
    ----------
    name : str
        Column of the second source.

    Returns
    -------
    ShellText
    """
    return ShellText(f"fill_record(data, {name!r})", f"--stand-in {name}")


def renamed(names: dict | pd.Index | set) -> Any:
    """
    Old names among some columns, with a warning.

    Where the new name is there, too, the old one is a column of the user's own.

    Parameters
    ----------
    names : dict, Index or set
        Names of columns.

    Returns
    -------
    dict of str
        New name to the old one that is there.

    Warns
    -----
    FutureWarning
        For each old name.
    """
    old_names = {new: old for old, new in RENAMED.items() if old in names}
    old_names = {new: old for new, old in old_names.items() if new not in names}
    for new, old in old_names.items():
        warnings.warn(
            f"the column {old} is called {new} now, and 0.2 will not know the old "
            f"name: write {new} for W per m² of module, and power_dc for W of a module "
            "or a plant",
            FutureWarning,
            stacklevel=3,
        )
    return old_names


def in_new_names(columns: dict) -> dict:
    """
    Columns, or what else is known by column, with those by an old name renamed.

    Parameters
    ----------
    columns : dict
        By name.

    Returns
    -------
    dict
        In the order of ``columns``.

    Warns
    -----
    FutureWarning
        For each old name.
    """
    new = {old: new for new, old in renamed(columns).items()}
    return {new.get(name, name): value for name, value in columns.items()}


def by_own_names(columns: dict) -> Any:
    """
    Columns by the package's names, where they are given by another of pvlib's.

    Parameters
    ----------
    columns : dict
        By name.

    Returns
    -------
    dict
        In the order of ``columns``.

    Warns
    -----
    FutureWarning
        For each old name.
    """
    renamed = in_new_names(columns)
    return {ALIASES.get(name, name): column for name, column in renamed.items()}


def as_numbers(column: pd.Series) -> pd.Series:
    """A column of objects as numbers, if all of them are; others as they are."""
    if column.dtype != object:
        return column
    try:
        return pd.to_numeric(column)
    except (TypeError, ValueError):
        return column


def of_several(columns: dict | pd.Index) -> tuple:
    """
    What a refusal adds where there are module sensors, and none is the usual one.

    Parameters
    ----------
    columns : dict or Index
        Names of the columns that are there.

    Returns
    -------
    tuple of str
        Parts of :func:`pvlib_fem._spelling.refusal`; empty with ``temp_module``, or
        fewer than two sensors.
    """
    sensors = [name for name in columns if twin_of(name) == "temp_module"]
    if "temp_module" in columns or len(sensors) < 2:
        return ()
    return f". Of {len(sensors)} module sensors give one as temp_module, or ", COMPARED


def numeric(columns: Mapping | pd.DataFrame) -> dict[str, pd.Series]:
    """
    Columns that hold numbers, and no infinity.

    Parameters
    ----------
    columns : dict of Series or DataFrame

    Returns
    -------
    dict of Series
        By name, in double precision.
    """
    floats = {
        name: column.astype(float)
        for name, column in columns.items()
        if pd.api.types.is_numeric_dtype(column)
    }
    return {n: c for n, c in floats.items() if not np.isinf(c.to_numpy()).any()}


def usable_drivers(
    columns: dict, record: Any, most_missing: float, taken: tuple = ()
) -> tuple[dict, dict]:
    """
    Numeric columns that say something of their own, and why others do not.

    Parameters
    ----------
    columns : dict of Series
    record : Record
        Screened, with the usual columns, of which no other may be a copy, and
        those that are numeric.
    most_missing : float
        Share of a column's rows that may be missing.
    taken : collection of str
        Names that no column may have.

    Returns
    -------
    dict of Series, dict of Because
    """
    used, refused = {}, {}
    seen = {name: record[name] for name in COLUMNS}
    # a logger's record number would be a drift of whatever drifts
    seen |= {"the time": record.inputs.seconds, "a count": np.arange(len(record.index))}
    there = {*columns, *COLUMNS}
    for name, column in columns.items():
        if name in record.inputs.columns:
            column = pd.Series(record[name], record.index)
        reason = why_no_driver(name, column, seen, most_missing)
        if name in taken:
            reason = because(Reason.TAKEN, column=name)
        if name.endswith(ORIGINAL) and name.removesuffix(ORIGINAL) in there:
            reason = because(Reason.ORIGINAL, column=name)
        if reason is None:
            used[name] = column.astype(float)
            seen[name] = used[name].to_numpy()
        else:
            refused[name] = reason
    return used, refused


def why_no_driver(
    name: str, column: Any, seen: dict, most_missing: float
) -> Because | None:
    """Why a column can be no driver, if it cannot."""
    if not pd.api.types.is_numeric_dtype(column):
        return because(Reason.NOT_NUMERIC, column=name)
    values = column.astype(float).to_numpy()
    if (there := np.isinf(values)).any():
        time = str(column.index[np.argmax(there)])
        return because(Reason.INFINITE, column=name, time=time)
    missing = int(np.count_nonzero(np.isnan(values)))
    if missing == len(values):
        return because(Reason.EMPTY, column=name)
    if (share := missing / len(values)) > most_missing:
        return because(Reason.MISSING, column=name, share=share)
    with np.errstate(over="ignore", invalid="ignore"):
        spread = values.std()
        spread = np.nanstd(values) if np.isnan(spread) else spread
    if not 0 < spread < np.inf and name not in GEOMETRY:
        if column.nunique() < 2:
            return because(Reason.CONSTANT, column=name)
        values_range = f"goes from {np.nanmin(values):.3g} to {np.nanmax(values):.3g}"
        return because(
            Reason.DOUBTFUL, column=name, doubt=f"{values_range}, no measurement"
        )
    if copies := [
        other for other, usual in seen.items() if is_scaled_copy(values, usual)
    ]:
        return because(Reason.COPY, column=name, other=copies[0])
    return None


def is_scaled_copy(one: np.ndarray, other: np.ndarray) -> bool:
    """
    Whether one column is a copy of another, but for a factor and an offset.

    Parameters
    ----------
    one, other : array, shape (rows,)
        NaN where missing.

    Returns
    -------
    bool
        False with fewer than three common values, or where one is constant.
    """
    some = slice(None, None, max(1, len(one) // FEW))
    return collinear(one[some], other[some]) and collinear(one, other)


def collinear(one: np.ndarray, other: np.ndarray) -> bool:
    both = np.isfinite(one) & np.isfinite(other)
    x, y = one[both], other[both]
    if both.sum() < 3 or x.std() == 0 or y.std() == 0:
        return False
    return abs(np.corrcoef(x, y)[0, 1]) > 1.0 - 1e-9
