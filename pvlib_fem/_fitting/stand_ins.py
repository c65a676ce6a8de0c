"""Use a second source of air temperature or wind instead of the usual one."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem._record.column_names import numeric, twin_of, with_aliases
from pvlib_fem.effects import several
from pvlib_fem.quality._limits import Limits
from pvlib_fem.quality._screen import screen_record

#: columns that another source can replace, and their units
SERVED = {"temp_air": "K", "wind_speed": "m/s"}
FEWEST = 500  # common rows that the level of the second source needs
NEAR = 1.5  # a longer time between values, in usual ones, is a gap
LONGEST = 3.0 * 3600.0  # s, longest time between values for linear interpolation
ALIKE = 0.8, 1.25  # range of the slope of one air temperature over another


@dataclass(frozen=True)
class StandIn:
    """
    A column that stands in for a usual one, ``factor * column + offset``.

    If its values are further apart than the rows, rows between them are interpolated.

    Attributes
    ----------
    usual, column : str
    factor : float
        Ratio of the mean wind speeds of rows with both. [-]
    offset : float
        Mean difference of the air temperatures of rows with both. [K]
    every : float
        Usual time between its values; 0 if each row has a value. [s]
    """

    usual: str
    column: str
    factor: float = 1.0
    offset: float = 0.0
    every: float = 0.0

    def fill_columns(self, columns: Any) -> Any:
        """Columns with the gaps of the usual column filled from the other."""
        if self.column not in columns:
            return columns
        other = interpolated_column(columns[self.column], self.every)
        other = self.factor * other + self.offset
        known = columns.get(self.usual)
        filled = other if known is None else known.where(known.notna(), other)
        return {**columns, self.usual: filled}


def interpolated_column(column: Any, every: Any) -> Any:
    """A column, interpolated between values that are usually ``every`` s apart."""
    known = column.dropna()
    if not every or len(known) < 2:
        return column
    at, times = seconds_of(known.index), seconds_of(column.index)
    values = np.interp(times, at, known.to_numpy())
    after = np.clip(np.searchsorted(at, times), 1, len(at) - 1)
    near = np.diff(at)[after - 1] <= NEAR * every
    inside = (times >= at[0]) & (times <= at[-1]) & near
    return column.where(column.notna(), pd.Series(values, column.index).where(inside))


def seconds_of(index: Any) -> Any:
    """Times as seconds."""
    return index.as_unit("ns").asi8 / 1e9


def spacing(column: Any) -> Any:
    """Usual time between values, if it exceeds the step of the rows; else 0. [s]"""
    known = column.dropna().index
    if len(known) < 2:
        return 0.0
    step, every = (
        float(np.median(np.diff(seconds_of(i)))) for i in (column.index, known)
    )
    return every if NEAR * step < every <= LONGEST else 0.0


def fill_record(
    data: pd.DataFrame,
    stand_ins: str | Iterable[str],
    limits: Limits | None = None,
) -> pd.DataFrame:
    """
    Fill gaps in air temperature or wind speed from a second source.

    Parameters
    ----------
    data : DataFrame
        Record with a DatetimeIndex.
    stand_ins : str or sequence of str
        Columns such as ``temp_air_2`` [°C] or ``wind_speed_airport`` [m/s], which stand
        in for the column that their names begin with.
    limits : pvlib_fem.quality.Limits, optional
        Thresholds of the screening.

    Returns
    -------
    DataFrame
        ``data`` without the second sources. ``attrs["notes"]`` describes the steps.

    Raises
    ------
    ValueError
        If a column is missing or stands in for nothing, or both have fewer than 500
        rows in common.

    Notes
    -----
    Without the usual column, the other is used as it is. Otherwise the other fills gaps
    and implausible values of the usual column. Its air temperature is shifted by the
    mean difference over common rows, and its wind is scaled by the ratio of the means.
    Hourly values, or values up to 3 h apart, are interpolated.

    Examples
    --------
    >>> import numpy as np
    >>> import pvlib_fem as fem
    >>> data = fem.datasets.synthetic(days=10, step=600)
    >>> data["temp_air_2"] = data["temp_air"].round() - 1.0
    >>> data.loc["2023-06-03", "temp_air"] = np.nan
    >>> filled = fem.fill_record(data, "temp_air_2")
    >>> print(filled.attrs["notes"][0])
    temp_air_2 stands in for temp_air in 144 rows, with 1 K added; where both are there
    they then differ by 0.29 K (root mean square of 1,296 rows)
    """
    columns, _, notes = with_stand_ins(with_aliases(data, ()), stand_ins, limits)
    own = stand_in_names(stand_ins)
    away = [name for name in own.values() if name not in columns]
    data = data.drop(columns=away).assign(**{n: columns[n] for n in own})
    data.attrs = {**data.attrs, "notes": notes}
    return data


def stand_in_names(names: Any) -> dict:
    """
    The column that stands in for each usual one.

    Parameters
    ----------
    names : str or iterable of str
        Columns such as ``temp_air_2`` or ``wind_speed_airport``.

    Returns
    -------
    dict
        ``temp_air``, ``wind_speed`` or both, to the name of the other column.

    Raises
    ------
    ValueError
        If a name begins with neither, or two stand in for the same column.
    """
    stand_ins: dict[str, str] = {}
    for name in several(names):
        usual = twin_of(name)
        if usual not in SERVED:
            raise ValueError(
                f"{name} stands in for nothing: second sources of air and wind do, "
                "whose names begin so, such as temp_air_2 and wind_speed_2"
            )
        if usual in stand_ins:
            raise ValueError(
                f"{stand_ins[usual]} and {name} both stand in for {usual}; give one"
            )
        stand_ins[usual] = name
    return stand_ins


def with_stand_ins(columns: Any, names: Any, limits: Any = None) -> Any:
    """
    Columns with gaps filled from others, the stand-ins, and notes.

    Parameters
    ----------
    columns : dict of pandas.Series, shape (rows,)
        Columns by name.
    names : str or sequence of str
        See :func:`stand_in_names`.
    limits : Limits, optional
        Thresholds of the screening.

    Returns
    -------
    dict of pandas.Series, tuple of StandIn, tuple of str
    """
    stand_ins, notes = [], []
    for usual, name in stand_in_names(names).items():
        there = numeric({n: columns[n] for n in (usual, name) if n in columns})
        if name not in there:
            raise ValueError(
                f"the data have no column of numbers {name}, which is to stand in for "
                f"{usual}; they have {', '.join(columns)}"
            )
        clean = {}
        for one in there:
            clean[one], more = cleaned_stand_in(columns[one], one, usual, limits)
            notes += more
        one, filled, said = level_of(clean, usual, name)
        columns = one.fill_columns({**columns, **clean})
        if filled:  # a column that fills another cannot cross-check it
            columns.pop(name)
        notes.append(said)
        stand_ins.append(one)
    return columns, tuple(stand_ins), tuple(notes)


def refuse_unlike(known: Any, other: Any) -> None:
    """Refuse a column that is in another unit, or no air temperature."""
    slope = float(np.polyfit(known, other, 1)[0])
    if not ALIKE[0] < slope < ALIKE[1]:
        raise ValueError(
            f"{other.name} changes by {slope:.2g} for each K of {known.name}; check "
            "its unit, which has to be °C, and where it is measured"
        )


def cleaned_stand_in(column: Any, name: str, usual: Any, limits: Any) -> Any:
    """A column without implausible values, and notes on these."""
    screened = screen_record(pd.DataFrame({usual: column}), limits)
    lines = [line for line in screened.notes if line.startswith(usual)]
    return screened.cleaned[usual].rename(name), [
        line.replace(usual, name, 1) for line in lines
    ]


def level_of(columns: Any, usual: Any, name: str) -> Any:
    """The stand-in of a column, the number of rows it fills, and a note."""
    other, known = columns[name], columns.get(usual)
    every = spacing(other)
    lines = f", on straight lines between values {every / 60:.3g} min apart"
    lines *= every > 0.0
    if known is None or known.isna().all():
        words = f"there is no {usual}: {name} stands in for it{lines}"
        return StandIn(usual, name, every=every), len(other), words
    filled = int((known.isna() & interpolated_column(other, every).notna()).sum())
    both = known.notna() & other.notna()
    if both.sum() < FEWEST:
        raise ValueError(
            f"{name} and {usual} have {int(both.sum()):,} rows in common, too few for "
            f"{name} to stand in, of {FEWEST}; give one of them alone"
        )
    if usual == "wind_speed":
        factor = float(known[both].mean() / max(other[both].mean(), 1e-9))
        one, how = StandIn(usual, name, factor, 0.0, every), f"times {factor:.3g}"
    else:
        refuse_unlike(known[both], other[both])
        offset = float((known - other)[both].mean())
        one = StandIn(usual, name, 1.0, offset, every)
        how = f"with {offset:.2g} K added"
    if not filled:
        return one, 0, f"{usual} has no gap in which {name} could stand in"
    residual = known[both] - (one.factor * other + one.offset)[both]
    rms = float(np.sqrt((residual**2).mean()))
    return (
        one,
        filled,
        (
            f"{name} stands in for {usual} in {filled:,} rows, {how}{lines}; where "
            f"both are there they then differ by {rms:.2g} {SERVED[usual]} (root mean "
            f"square of {int(both.sum()):,} rows)"
        ),
    )
