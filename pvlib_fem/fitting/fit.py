"""Fit the FEM coefficients to a measured record, with honest errors."""

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np
import pandas as pd

from pvlib_fem import scores
from pvlib_fem.effects import EffectLike, find, several
from pvlib_fem.fitting.daily import errors
from pvlib_fem.fitting.memory import memory_notes
from pvlib_fem.fitting.result import FemFit
from pvlib_fem.fitting.rows import Rows, daily_sums
from pvlib_fem.fitting.search import minimise, natural, possible, with_tables
from pvlib_fem.paper.filters import counted
from pvlib_fem.paper.recipe import MODELS, paper_stages
from pvlib_fem.quality.limits import Limits
from pvlib_fem.quality.screen import screened
from pvlib_fem.quality.units import oddities
from pvlib_fem.record.checks import as_record
from pvlib_fem.record.columns import ALIASES, COLUMNS
from pvlib_fem.spelling import LEAST_SQUARES, argument, refusal
from pvlib_fem.statistics.clusters import calendar_weeks
from pvlib_fem.statistics.leastsquares import FLAT
from pvlib_fem.thermal.model import INSTANT, thermal_model

METHODS = ("least_squares", "paper")
MEMORIES = ("tau", "capacity")  # of which each dynamics has one
ROUGH = 1e-8  # relative fall of the cost that ends a step before the last


def fit_fem(
    poa_global: pd.Series,
    temp_air: pd.Series,
    wind_speed: pd.Series,
    temp_module: pd.Series,
    model: str = "wm1",
    dynamics: str = "ewm",
    method: str = "least_squares",
    holdout: pd.Series | None = None,
    calm_wind: float = 0.5,
    check_units: bool = True,
    effects: EffectLike | Iterable[EffectLike] = (),
    night: bool = False,
    fixed: Mapping[str, float] | None = None,
    offset: float | str | None = "night",
    limits: Limits | None = None,
    **drivers: pd.Series,
) -> FemFit:
    """
    Fit a steady model, made dynamic, to measured module temperature.

    The FEM method: Filter, Exponential weighted mean, Mean bias [1]_. By
    default all coefficients, the time constant and the bias are fitted
    together by least squares.

    Parameters
    ----------
    poa_global : Series
        Irradiance in the plane of the array, with a DatetimeIndex. [W/m²]
    temp_air : Series
        Air temperature. [°C]
    wind_speed : Series
        Wind speed. [m/s]
    temp_module : Series
        Measured module temperature. [°C]
    model : str, default "wm1"
        ``"ross"``, ``"sapm"``, ``"faiman"``, ``"wm1"``, ``"wm2"``, ``"pvsyst"``,
        ``"noct"`` or ``"noct_sam"``.
    dynamics : str, default "ewm"
        ``"steady"``; ``"ewm"``, the paper's smoothing of irradiance and wind
        with one tau; ``"balance"``, the exact heat balance.
    method : str, default "least_squares"
        Or ``"paper"``: the paper's own recipe, with regressions of five-minute
        averages for the coefficients, step changes for tau and the mean error
        of the training days for the bias.
    holdout : Series of bool, optional
        Rows to hold out. By default the weekend days where the record has two
        weekends, as in the paper, else every other day.
    calm_wind : float, default 0.5
        Wind below which ``method="paper"`` takes the air as calm. [m/s]
    check_units : bool, default True
        Refuse columns that look to be in another unit, or swapped.
    effects : str, dict, Effect or sequence of them, optional
        Physical effects to fit beside the model: by name
        (``pvlib_fem.effects.EFFECTS``), by name and settings, as ``{"name":
        "sky_radiation", "source": "humidity"}``, or of one's own. ``scores`` has a
        row for each, in this order.
    night : bool, default False
        Whether night rows count, too. By day only, as in the paper, the
        coefficients serve the energy; nights tell more of sky and storage.
    fixed : dict, optional
        Coefficients that are known and not fitted, as ``{"tau": 378.0}`` or
        ``{"rain.film": 20.0}``; they have no error. So are constants of the model,
        such as the ``module_efficiency`` of pvsyst, for other than their defaults.
    offset : str, float or None, default "night"
        Over-temperature without irradiance, which ``method="paper"`` takes off
        before its regressions: ``"night"``, its mean by night; ``"calm"``, the
        intercept of the line of calm air; a number [K]; or None, nothing, though
        k keeps its line's intercept. The docs' page on the paper compares them.
    limits : pvlib_fem.quality.limits.Limits, optional
        Thresholds of the screening other than the usual.
    **drivers : Series
        Further columns that the effects need, by name: ``wind_direction`` [°
        from north], ``p_dc`` [W per m² of module], ``longwave_down`` [W/m²],
        ``relative_humidity`` [%], ``precipitation`` [mm/h], ``snow_depth`` [cm], and
        ``solar_zenith``, ``solar_azimuth``, ``surface_tilt``, ``surface_azimuth``
        [°], of which ``pvlib_fem.drivers.sun`` gives the first two.

    Returns
    -------
    FemFit

    Raises
    ------
    ValueError
        If the record is unusable (times, columns, units, too many impossible
        values), a name is unknown, or a step has too few points. The message
        names the column or step, the value and the remedy.

    Notes
    -----
    What was not measured (:func:`pvlib_fem.screen`) is left out, and ``notes`` say
    what.

    The residual is that of the paper's daytime filter (:mod:`pvlib_fem.paper`);
    the recursion runs over all rows, night included. Errors come from leaving
    out each training day in turn, so they survive autocorrelation within a
    day; below 5 training days they are NaN and the fit goes on.

    The tau of ``method="paper"`` runs backwards: it falls as the true time
    constant grows, see the table at :func:`pvlib_fem.paper.time_constant`.
    That method gives no errors.

    References
    ----------
    .. [1] B. Herteleer et al., "Investigating methods to improve photovoltaic
       thermal models at second-to-minute timescales", 2022, Eq. 28.
       :doi:`10.22541/au.166922866.68736478`
    """
    target = thermal_model(model, dynamics, map(find, several(effects)))
    target = replace(target, held=possible(target, fixed or {}))
    drivers = {ALIASES.get(name, name): column for name, column in drivers.items()}
    refuse_coefficients(target, drivers)
    target.check_drivers(drivers)
    if method not in METHODS:
        raise ValueError(f"unknown method {method!r}; they are {', '.join(METHODS)}")
    if method == "paper":
        refuse_paper(target, fixed, night)
    columns = (poa_global, temp_air, wind_speed, temp_module)
    record, faults = screened(as_record(*columns, **drivers), limits, check_units)
    filtered = counted(record.inputs.columns, night)
    filtered &= record.known(target.drivers)
    notes = [*faults.notes, *oddities(record.inputs, limits)]
    out = held_out(record, filtered, holdout, notes)
    train = filtered & ~out
    if method == "paper":
        stages = paper_stages(target, record, train, ~out, calm_wind, offset, notes)
        stderr = dict.fromkeys(stages["fem"][1], np.nan)
        at_bound, converged, daily = (), True, None
        notes.append("no errors: the paper's recipe gives none")
    else:
        target, record, stages, minimum = least_squares_stages(
            target, record, train, ~out
        )
        source = Rows(record, train)
        at_bound = tuple(np.array(target.free)[minimum.at_bound].tolist())
        converged = minimum.converged
        found = last(stages)[1]
        daily = daily_sums(target, found, source, at_bound)
        stderr = errors(target, daily, at_bound, notes)
        days = len(np.unique(record.days[train]))
        notes += memory_notes(source, target, found, stderr, at_bound, days)
        if not converged:
            notes.append("the search did not converge: do not trust the numbers")
    test = filtered & out
    table, temperature = score_table(record, stages, train, test)
    return finished(
        target,
        record,
        temperature,
        (train, test, out),
        (last(stages)[1], stderr, at_bound, converged),
        scores=table,
        notes=tuple(notes),
        method=method,
        night=night,
        daily=daily,
    )


def refuse_paper(target, fixed, night):
    """Refuse what the paper's recipe cannot fit."""
    name, paper = target.steady_model.name, argument("method", "paper")
    if name not in MODELS:
        has = f" has no {name}; it has {', '.join(MODELS)}, or use "
        raise refusal(paper, has, LEAST_SQUARES)
    if target.dynamics == "balance":
        ewm = argument("dynamics", "ewm")
        raise refusal(paper, " has no heat balance; use ", ewm, ", or ", LEAST_SQUARES)
    if target.effects:
        raise refusal(paper, " has no effects; use ", LEAST_SQUARES)
    if fixed:
        raise refusal(paper, " holds nothing; use ", LEAST_SQUARES)
    if night:
        raise ValueError("method='paper' is for daytime rows; use night=False")


def refuse_coefficients(target, drivers):
    """Refuse a number that is to be held where columns are given."""
    for name, value in drivers.items():
        if name in target.parameters or (np.isscalar(value) and name in MEMORIES):
            raise ValueError(
                f"{name} is a coefficient and no column; to hold it give "
                f"fixed={{{name!r}: {value!r}}}"
            )


def finished(target, record, temperature, parts, minimum, **how):
    """The result, from the last temperature and minimum."""
    train, test, out = parts
    found, stderr, at_bound, converged = minimum
    coefficients = public(target, found)
    residual = record["temp_module"] - temperature
    days = record.days
    return FemFit(
        model=target.steady_model.name,
        dynamics=target.dynamics,
        effects=target.effects,
        coefficients=coefficients,
        stderr={name: stderr.get(name, 0.0) for name in coefficients},
        residual=pd.Series(residual, record.index, name="residual"),
        at_bound=at_bound,
        converged=converged,
        train_days=len(np.unique(days[train])),
        test_days=len(np.unique(days[test])),
        holdout=pd.Series(out, record.index, name="holdout"),
        record=record,
        base=target.base if target.effects else None,
        fixed=dict(target.held),
        **how,
    )


def held_out(record, filtered, holdout, notes):
    """Boolean array of the rows that the fit does not see."""
    index = record.index
    if holdout is not None:
        out = record.rows(holdout)
    else:
        weekend = (record.dates + 3) % 7 >= 5  # 1970-01-01 was a Thursday
        weeks = calendar_weeks(record.dates)
        two = len(np.unique(weeks[weekend & filtered])) >= 2
        out = weekend if two else record.days % 2 == 1
        if not (filtered & ~out).any():
            out = np.zeros(len(index), dtype=bool)
    if not (filtered & out).any():
        notes.append("no row that counts is held out: test scores are NaN")
    return out


def needed(step, rows, parameters):
    if rows <= parameters:
        raise ValueError(
            f"{step} needs more than {parameters} rows and has {rows}: training "
            "rows with all four columns, more than 20 W/m², the module at 0 to 80 "
            "°C, air at -20 to 60 °C and wind up to 25 m/s; use a longer record"
        )


def least_squares_stages(target, record, train, not_held_out):
    """The model with its base, its record, the steps to it, and the last minimum."""
    needed("least squares", int(train.sum()), len(target.free))
    complete = np.isfinite(sum(record[name] for name in COLUMNS))
    plain = replace(target, effects=())
    steady = replace(plain, dynamics="steady")
    start = {name: row.start for name, row in target.parameters.items()}
    steps = [
        ("standard", steady, complete & not_held_out, False),
        ("filter", steady, train, False),
        ("ewm", plain, train, False),
        ("fem", plain, train, True),
    ]
    stages, thin, source = {}, start, None
    for name, model, rows, biased in steps:
        # what a later step starts from need not be as flat as the last
        flat = ROUGH if target.effects or name != "fem" else FLAT
        if source is None or source.counts is not rows:
            source = Rows(record, rows)
            some = source.thinned()
        if some:
            # what a stage changes is nearly the same on a part of the rows
            before, (_, thin) = thin, minimise(model, some, thin, biased, ROUGH)
            start = {n: value + thin[n] - before[n] for n, value in start.items()}
        minimum, start = minimise(model, source, start, biased, flat)
        stages[name] = (model, natural(model, start)[0])
    if not target.effects:
        return target, record, stages, minimum
    target = replace(target, base=public(plain, last(stages)[1]))
    found = effect_stages(target, record, train, start)
    own = target.rebased(public(target, last(found[1])[1]))
    if own is not target:
        found = effect_stages(own, record, train, start)
    record, more, minimum = found
    return own, record, stages | more, minimum


def effect_stages(target, record, train, start):
    """The record with the effects' drivers, the steps that add each, the minimum."""
    record = replace(record, inputs=target.with_drivers(record.inputs))
    stages, source = {}, Rows(record, train)
    for i, added in enumerate(target.effects, start=1):
        model = replace(target, effects=target.effects[:i])
        flat = FLAT if i == len(target.effects) else ROUGH
        tabled = with_tables(model, record)
        minimum, start = minimise(tabled, source, start, True, flat)
        stages[f"+ {added.name}"] = (model, natural(model, start)[0])
    return record, stages, minimum


def last(stages):
    """What the last step came to."""
    return list(stages.values())[-1]


def public(model, coefficients):
    """Coefficients that unpack into the temperature function of the dynamics."""
    constants = [name for name in model.constants if name in model.held]
    names = [*model.parameters, *constants]
    values = {name: float(coefficients[name]) for name in names}
    if model.dynamics == "steady":
        bias = values.pop("bias")
        values = {**values, "tau": INSTANT, "bias": bias}
    return values


def score_table(record, stages, train, test):
    """RMSE, MAE and MBE of every stage, and the temperature of the last."""
    table = {}
    for name, (model, coefficients) in stages.items():
        temperature = model.temperature(record.inputs, coefficients)
        error = record["temp_module"] - temperature
        table[name] = {
            f"{score}_{part}": value
            for part, rows in (("train", train), ("test", test))
            for score, value in scores.all_three(error[rows]).items()
        }
    return pd.DataFrame.from_dict(table, orient="index"), temperature
