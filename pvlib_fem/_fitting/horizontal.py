"""Transpose a record of horizontal irradiance to the plane of the module."""

from dataclasses import dataclass, replace
from typing import Any, overload

import numpy as np
import pandas as pd
from pvlib.location import Location
from pvlib.pvsystem import AbstractMount

from pvlib_fem._record.column_names import numeric, with_aliases
from pvlib_fem._record.parquet import Made, ParquetRecord
from pvlib_fem._record.ranges import possible_range
from pvlib_fem._record.resampling import Sums
from pvlib_fem._spelling import argument, no_columns, refusal
from pvlib_fem.drivers import checked_place
from pvlib_fem.drivers._mounts import plane_of_rows
from pvlib_fem.drivers._planes import ByColumns
from pvlib_fem.drivers._transposition import (
    PARTS,
    check_transposition,
    in_plane,
    is_split,
)
from pvlib_fem.quality._limits import Limits
from pvlib_fem.quality._noon import (
    SolarNoon,
    lateness_of,
    solar_noon_shift,
)
from pvlib_fem.quality._screen import screen_record

LIGHT = "poa_global"
NAMES = {"perez": "Perez", "haydavies": "Hay and Davies"}
MEANS = 300.0  # s, of the means by which a clock is checked
KILOWATTS = 3.0  # W/m²; the largest irradiance of a record is never below


@overload
def transpose_record(
    data: pd.DataFrame,
    location: Location,
    surface_tilt: float | pd.Series | None = ...,
    surface_azimuth: float | pd.Series | None = ...,
    transposition: str = ...,
    limits: Limits | None = ...,
    mount: AbstractMount | None = ...,
) -> pd.DataFrame: ...


@overload
def transpose_record(
    data: ParquetRecord,
    location: Location,
    surface_tilt: float | pd.Series | None = ...,
    surface_azimuth: float | pd.Series | None = ...,
    transposition: str = ...,
    limits: Limits | None = ...,
    mount: AbstractMount | None = ...,
) -> ParquetRecord: ...


def transpose_record(
    data: pd.DataFrame | ParquetRecord,
    location: Location,
    surface_tilt: float | pd.Series | None = None,
    surface_azimuth: float | pd.Series | None = None,
    transposition: str = "perez",
    limits: Limits | None = None,
    mount: AbstractMount | None = None,
) -> pd.DataFrame | ParquetRecord:
    """
    Add the irradiance in the plane of the module to a record of horizontal irradiance.

    Parameters
    ----------
    data : DataFrame or ParquetRecord
        Record with a DatetimeIndex and ``ghi``. If it has ``dni`` and ``dhi``, they
        replace Erbs' correlation [1]_. [W/m²] Or files of :func:`open_parquet`.
    location : pvlib.location.Location
        Of the plant.
    surface_tilt, surface_azimuth : float or Series, optional
        Orientation of the module; azimuth from north, clockwise. If it changes with
        time, Series, or columns of ``data`` with these names. [°]
    transposition : str, default "perez"
        Model of the sky: ``"perez"`` [2]_ or ``"haydavies"`` [3]_.
    limits : pvlib_fem.quality.Limits, optional
        Thresholds of the screening of ``ghi``.
    mount : pvlib.pvsystem.SingleAxisTrackerMount, optional
        A tracker, instead of the orientation.

    Returns
    -------
    DataFrame or ParquetRecord
        ``data`` with ``poa_global`` [W/m²]. ``attrs["notes"]`` describes the steps.
        Files are not changed: they are transposed block by block as they are read,
        and their ``notes`` say so.

    Raises
    ------
    ValueError
        If ``data`` has ``poa_global`` or no ``ghi``, the plane is not given, or the
        times do not agree with the solar position.

    Notes
    -----
    The solar position is that at the times of the rows, or half a step before or after
    them if the daily course of ``ghi`` shows that they are means over the step that
    ends or begins there (of steps above 5 min); a note says so.
    :doc:`/guide/fewer_sensors` has the loss of accuracy.

    References
    ----------
    .. [1] D. G. Erbs, S. A. Klein and J. A. Duffie, Solar Energy 28, 293 (1982),
       :doi:`10.1016/0038-092X(82)90302-4`
    .. [2] R. Perez et al., Solar Energy 44, 271 (1990),
       :doi:`10.1016/0038-092X(90)90055-H`
    .. [3] J. E. Hay and J. A. Davies, Proc. First Canadian Solar Radiation Data
       Workshop, 59 (1980)

    Examples
    --------
    >>> import pvlib
    >>> import pvlib_fem as fem
    >>> data = fem.datasets.synthetic(days=5, step=600)
    >>> place = pvlib.location.Location(35.0, -106.0), 35.0, 180.0
    >>> record = fem.transpose_record(data.drop(columns="poa_global"), *place)
    >>> print(record.attrs["notes"][0])
    there is no poa_global: it is transposed from ghi with measured dni and dhi and the
    sky of Perez
    >>> error = (record["poa_global"] - data["poa_global"]).abs().mean()
    >>> bool(error < 15.0)  # W/m²; that record has an isotropic sky
    True
    """
    place = checked_place(location, surface_tilt, surface_azimuth, mount)
    if isinstance(data, ParquetRecord):
        return files_in_plane(data, place, transposition, limits)
    columns = with_aliases(data, ("ghi",))
    if LIGHT in columns:
        raise ValueError(f"data have {LIGHT}, so no transposition is needed; drop one")
    place = plane_of_rows(data, place)
    columns, notes = with_plane(columns, data.index, place, transposition, limits)
    data = data.assign(**{LIGHT: columns[LIGHT]})
    data.attrs = {**data.attrs, "notes": notes}
    return data


@dataclass(frozen=True, eq=False)
class InPlane:
    """Irradiance in the plane of the module for rows of files."""

    place: dict
    transposition: str
    late: float = 0.0  # [s]

    def __call__(self, columns: Any, index: Any) -> Any:
        light = {
            n: possible_values(n, columns[n]) for n in ("ghi", *PARTS) if n in columns
        }
        how = self.place, self.transposition, self.late
        return in_plane(light, index, *how).to_numpy()


def files_in_plane(
    source: Any, place: Any, transposition: Any, limits: Any = None
) -> Any:
    """
    Files with ``poa_global``, which is transposed block by block.

    Of the files' own values only impossible ones are removed before; the screening of
    a fit has the rules for ``poa_global``, which it then applies to what is made.

    Parameters
    ----------
    source : ParquetRecord
        Files with ``ghi`` [W/m²].
    place : dict
        From :func:`pvlib_fem.drivers.checked_place`.
    transposition : str
        ``"perez"`` or ``"haydavies"``.
    limits : Limits, optional
        Thresholds by which the times are checked.

    Returns
    -------
    ParquetRecord
    """
    check_transposition(transposition, place)
    if isinstance(place["mount"], ByColumns):
        raise ValueError(
            "of files the plane is given as numbers, or as a tracker with mount=, and "
            "not as Series"
        )
    if source.made or LIGHT in {*source.columns, *source.partial}:
        raise ValueError(f"data have {LIGHT}, so no transposition is needed")
    source.needing(["ghi"])
    parts = ("ghi", *PARTS) if is_split(source.columns) else ("ghi",)
    needs = {name: source.columns[name] for name in parts}
    sums = Sums(MEANS, 1.0)
    for block in source.blocks(["ghi"]):
        sums.add(block.index, {"ghi": possible_values("ghi", block["ghi"])})
    means = sums.inputs()
    times = pd.DatetimeIndex(means.index)
    horizontal = (means.columns["ghi"], times, place["location"], 0.0, 180.0)
    noon = solar_noon_shift(*horizontal, limits)
    refuse_clock(noon.faults)
    late, lines = sun_of_means(noon, times)
    rest = {n: c for n, c in source.columns.items() if n not in ("ghi", *PARTS)}
    return replace(
        source,
        columns=rest,
        made=Made(LIGHT, needs, InPlane(place, transposition, late)),
        notes=(*source.notes, words_of(needs, transposition), *lines),
    )


def with_plane(
    columns: Any,
    index: Any,
    place: Any,
    transposition: Any,
    limits: Any = None,
    check_units: bool = True,
    check_clock: bool = True,
) -> Any:
    """
    Columns with ``poa_global``, transposed from ``ghi`` if it is missing, and notes.

    Parameters
    ----------
    columns : dict of pandas.Series, shape (rows,)
        Columns by name; irradiance in W/m².
    index : pandas.DatetimeIndex, shape (rows,)
        Their times.
    place : dict
        From :func:`pvlib_fem.drivers.checked_place`.
    transposition : str
        ``"perez"`` or ``"haydavies"``.
    limits : Limits, optional
        Thresholds of the screening of ``ghi``.
    check_units : bool, default True
        Refuse irradiance in kW/m².
    check_clock : bool, default True
        Refuse times that do not fit the sun.

    Returns
    -------
    dict of pandas.Series, tuple of str
    """
    check_transposition(transposition, place)
    if LIGHT in columns:
        return columns, (f"{LIGHT} was measured, and nothing is transposed",)
    if "ghi" not in columns:
        raise refusal(
            f"{no_columns([LIGHT, 'ghi'])}; they have {', '.join(columns)}; name a "
            "column of horizontal irradiance ghi, or drop ",
            argument("transposition", transposition),
        )
    if not isinstance(index, pd.DatetimeIndex):
        raise ValueError("a transposition needs a DatetimeIndex; set one")
    parts = ("ghi", *PARTS) if is_split(columns) else ("ghi",)
    light, notes = {}, [words_of(columns, transposition)]
    for name in parts:
        light[name], more = cleaned_irradiance(name, columns, limits, check_units)
        notes += more
    horizontal = (light["ghi"].to_numpy(), index, place["location"], 0.0, 180.0)
    noon = solar_noon_shift(*horizontal, limits)
    if check_clock:
        refuse_clock(noon.faults)
    late, lines = sun_of_means(noon, index)
    made = in_plane(light, index, place, transposition, late)
    return {**columns, **light, LIGHT: made}, (*notes, *lines)


def sun_of_means(noon: SolarNoon, index: pd.DatetimeIndex) -> tuple[float, list[str]]:
    """By how much rows of means are after the middle of their steps [s], and a line."""
    label = noon.label(index)
    if not label:
        return 0.0, []
    at = "ends" if label > 0 else "begins"
    line = (
        f"by the middle of the day's light each row of ghi is a mean over the step "
        f"that {at} at its time: it is transposed with the sun at the middle of that"
    )
    return lateness_of(label, index), [line]


def refuse_clock(faults: Any) -> None:
    """
    Refuse times that do not agree with the solar position.

    Parameters
    ----------
    faults : dict of str
        ``SolarNoon.faults`` of horizontal irradiance; empty without a fault.

    Raises
    ------
    ValueError
        If there is a fault.
    """
    if faults:
        why = "; ".join(faults[name] for name in sorted(faults))
        raise ValueError(f"ghi cannot be transposed: {why}")


def transposed_again(
    columns: dict, index: pd.Index, place: dict, transposition: str, label: float = 0.0
) -> dict:
    """
    Columns with ``poa_global`` for further data, transposed as in the fit.

    Parameters
    ----------
    columns : dict of pandas.Series, shape (rows,)
        Further data by name.
    index : pandas.DatetimeIndex, shape (rows,)
        Its times.
    place : dict
        From :func:`pvlib_fem.drivers.checked_place`.
    transposition : str
        ``"perez"``, ``"haydavies"``, or ``""`` if the fit had none.
    label : float, default 0
        From the middle of its step to the time of a row. [steps]

    Returns
    -------
    dict of pandas.Series, shape (rows,)
        ``columns`` itself if nothing was transposed or it has ``poa_global`` [W/m²].

    Raises
    ------
    ValueError
        If ``poa_global`` and ``ghi`` are missing.
    """
    if not transposition or LIGHT in columns:
        return columns
    if "ghi" not in columns:
        raise ValueError(
            f"{no_columns([LIGHT])}, and no column ghi, from which it was transposed; "
            f"they have {', '.join(columns)}"
        )
    check_transposition(transposition, place)
    names = ("ghi", *PARTS) if is_split(columns) else ("ghi",)
    light = {name: possible_values(name, columns[name]) for name in names}
    late = lateness_of(label, index)
    return {**columns, LIGHT: in_plane(light, index, place, transposition, late)}


def possible_values(name: str, column: Any) -> Any:
    """A column with NaN instead of impossible values."""
    low, high, _ = possible_range(name)
    known = (column >= low) & (column <= high)
    if isinstance(column, pd.Series):
        return column.where(known)
    return np.where(known, column, np.nan)


def cleaned_irradiance(name: str, columns: Any, limits: Any, check_units: bool) -> Any:
    """A column of irradiance without implausible values, and notes on these."""
    if name not in numeric(columns):
        raise ValueError(f"{name} is not numeric, or infinite; give it as numbers")
    column = columns[name]
    most = float(column.quantile(0.999))
    if check_units and 0.0 < most < KILOWATTS:
        raise refusal(
            f"{name} looks to be in kW/m²: it is {most:.2g} at most; multiply it by "
            "1000 (--unit ",
            f"{name}=kW/m²), or give ",
            argument("check_units", False),
        )
    others = {n: columns[n] for n in ("temp_air",) if n in numeric(columns)}
    # the rules for irradiance in the plane apply to ghi; beam may start abruptly
    called = LIGHT if name == "ghi" else name
    screened = screen_record(pd.DataFrame({called: column, **others}), limits)
    lines = [line for line in screened.notes if line.startswith(called)]
    return screened.cleaned[called], [line.replace(called, name, 1) for line in lines]


def words_of(columns: Any, transposition: Any) -> Any:
    """Description of the transposition."""
    split = "measured dni and dhi" if is_split(columns) else "Erbs' correlation"
    return (
        f"there is no {LIGHT}: it is transposed from ghi with {split} and the sky of "
        f"{NAMES[transposition]}"
    )
