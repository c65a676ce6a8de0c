"""A record of horizontal irradiance, brought into the plane of the module."""

import pandas as pd
from pvlib.location import Location

from pvlib_fem.drivers import checked_place
from pvlib_fem.drivers.transposition import (
    PARTS,
    check_transposition,
    in_plane,
    is_split,
)
from pvlib_fem.quality.limits import Limits
from pvlib_fem.quality.noon import solar_noon_shift
from pvlib_fem.quality.screen import screen_record
from pvlib_fem.record.columns import numeric, with_aliases
from pvlib_fem.record.ranges import possible
from pvlib_fem.spelling import argument, refusal

LIGHT = "poa_global"
NAMES = {"perez": "Perez", "haydavies": "Hay and Davies"}
KILOWATTS = 3.0  # W/m², below which no light of a whole record is


def transpose_record(
    data: pd.DataFrame,
    location: Location,
    surface_tilt: float,
    surface_azimuth: float,
    transposition: str = "perez",
    limits: Limits | None = None,
) -> pd.DataFrame:
    """
    Add the irradiance in the plane of the module to a record that has it horizontal.

    Parameters
    ----------
    data : DataFrame
        With a DatetimeIndex and ``ghi``, and perhaps ``dni`` and ``dhi``, which are
        taken instead of Erbs' correlation [1]_ where both are there. [W/m²]
    location : pvlib.location.Location
    surface_tilt, surface_azimuth : float
        Of the module; azimuth from north, clockwise. [°]
    transposition : str, default "perez"
        Model of the sky: ``"perez"`` [2]_ or ``"haydavies"`` [3]_.
    limits : pvlib_fem.quality.limits.Limits, optional
        Thresholds of the screening of ``ghi`` other than the usual.

    Returns
    -------
    DataFrame
        ``data`` with ``poa_global`` [W/m²]. ``attrs["notes"]`` says what was done.

    Raises
    ------
    ValueError
        If ``poa_global`` is there, ``ghi`` is not, the plane is not given, or the times
        do not fit the sun.

    Notes
    -----
    The sun is taken where it stands at the times of the rows. Where rows are means over
    a long step, give the times of its middle. What that costs in accuracy is in
    :doc:`/guide/fewer_sensors`.

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
    >>> found = fem.transpose_record(data.drop(columns="poa_global"), *place)
    >>> print(found.attrs["notes"][0])
    there is no poa_global: it is transposed from ghi with measured dni and dhi and the
    sky of Perez
    >>> error = (found["poa_global"] - data["poa_global"]).abs().mean()
    >>> bool(error < 15.0)  # W/m²; that record has an isotropic sky
    True
    """
    place = checked_place(location, surface_tilt, surface_azimuth)
    columns = with_aliases(data, ("ghi",))
    if LIGHT in columns:
        raise ValueError(f"{LIGHT} is there, and needs no transposition; drop one")
    found, notes = with_plane(columns, data.index, place, transposition, limits)
    data = data.assign(**{LIGHT: found[LIGHT]})
    data.attrs = {**data.attrs, "notes": notes}
    return data


def with_plane(
    columns,
    index,
    place,
    transposition,
    limits=None,
    check_units=True,
    check_clock=True,
):
    """
    Columns with ``poa_global``, which is transposed where it lacks, and notes.

    Parameters
    ----------
    columns : dict of Series
    index : DatetimeIndex
    place : dict
        ``location``, ``surface_tilt``, ``surface_azimuth``.
    transposition : str
    limits : Limits, optional
    check_units : bool, default True
    check_clock : bool, default True
        Refuse times that do not fit the sun.

    Returns
    -------
    dict of Series, tuple of str
    """
    check_transposition(transposition, place)
    if LIGHT in columns:
        return columns, (f"{LIGHT} was measured, and nothing is transposed",)
    if "ghi" not in columns:
        raise refusal(
            f"data lack {LIGHT} and ghi; they have {', '.join(columns)}; name a column "
            "of horizontal irradiance ghi, or drop ",
            argument("transposition", transposition),
        )
    if not isinstance(index, pd.DatetimeIndex):
        raise ValueError("a transposition needs a DatetimeIndex; set one")
    parts = ("ghi", *PARTS) if is_split(columns) else ("ghi",)
    light, notes = {}, [words_of(columns, transposition)]
    for name in parts:
        light[name], more = cleaned(name, columns, limits, check_units)
        notes += more
    if check_clock:
        horizontal = (light["ghi"].to_numpy(), index, place["location"], 0.0, 180.0)
        refuse_clock(solar_noon_shift(*horizontal, limits).faults)
    return {**columns, **light, LIGHT: in_plane(light, index, place, transposition)}, (
        *notes,
    )


def refuse_clock(faults):
    """Refuse times that do not fit the sun, at which no plane can be told."""
    if faults:
        why = "; ".join(faults[name] for name in sorted(faults))
        raise ValueError(f"ghi cannot be transposed: {why}")


def again(columns, index, place, transposition):
    """``poa_global`` of further data, as it was transposed; other columns stay."""
    if not transposition or LIGHT in columns:
        return columns
    if "ghi" not in columns:
        raise ValueError(
            f"data lack {LIGHT}, and ghi, of which it was transposed; they have "
            f"{', '.join(columns)}"
        )
    check_transposition(transposition, place)
    names = ("ghi", *PARTS) if is_split(columns) else ("ghi",)
    light = {name: within(name, columns[name]) for name in names}
    return {**columns, LIGHT: in_plane(light, index, place, transposition)}


def within(name, column):
    """A column with NaN for what no sensor can have measured."""
    low, high, _ = possible(name)
    return column.where((column >= low) & (column <= high))


def cleaned(name, columns, limits, check_units):
    """A column of irradiance without what was not measured, and what that was."""
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
    beside = {n: columns[n] for n in ("temp_air",) if n in numeric(columns)}
    # the rules for light in the plane are those for all light, but beam comes at once
    called = LIGHT if name == "ghi" else name
    found = screen_record(pd.DataFrame({called: column, **beside}), limits)
    lines = [line for line in found.notes if line.startswith(called)]
    return found.cleaned[called], [line.replace(called, name, 1) for line in lines]


def words_of(columns, transposition):
    """What was done, in words."""
    split = "measured dni and dhi" if is_split(columns) else "Erbs' correlation"
    return (
        f"there is no {LIGHT}: it is transposed from ghi with {split} and the sky of "
        f"{NAMES[transposition]}"
    )
