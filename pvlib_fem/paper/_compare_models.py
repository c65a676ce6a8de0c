"""Compare several models on one record, step by step."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem import scores
from pvlib_fem._fitting.fit_stages import stages_of
from pvlib_fem._fitting.frame_rows import Frame
from pvlib_fem._fitting.holdout import held_out
from pvlib_fem._record.checks import is_number, usual_step
from pvlib_fem._record.column_names import COLUMNS, by_own_names, with_aliases
from pvlib_fem._record.filters import daytime, night
from pvlib_fem._record.inputs import as_record
from pvlib_fem._spelling import no_columns
from pvlib_fem._thermal.model import thermal_model
from pvlib_fem._thermal.steady_models import STEADY_MODELS
from pvlib_fem.paper._comparison import FITTED, STEPS, Comparison
from pvlib_fem.paper._recipe import METHODS, MODELS, paper_stages
from pvlib_fem.paper.comparators import COMPARATORS, fitted
from pvlib_fem.quality._screen import screened

SCORES = {score.__name__: score for score in (scores.rmse, scores.mae, scores.mbe)}
LONGWAVE = "longwave_down"  # which Barry's model needs
PRESENT = 0.5  # least share of rows of a longer step
PARTS = {"day": daytime, "night": night}
#: the balance of one mass; Torres Lobera and Valkealahti integrate it by Euler's method
BALANCE = "torres_lobera"


def compare_models(
    poa_global: pd.Series | pd.DataFrame,
    temp_air: pd.Series | None = None,
    wind_speed: pd.Series | None = None,
    temp_module: pd.Series | None = None,
    models: str | Sequence[str] = MODELS,
    comparators: str | Sequence[str] = (*COMPARATORS, BALANCE),
    method: str = "least_squares",
    resolutions: float | Sequence[float] | None = None,
    holdout: pd.Series | None = None,
    calm_wind: float = 0.5,
    offset: float | str | None = "night",
    check_units: bool = True,
    **drivers: pd.Series,
) -> Comparison:
    """
    Fit several models to one record and compare their errors after each step.

    This makes the paper's Tables 4 and 5 and its Fig. 8 for your own record [1]_:
    steady models fitted to all rows (``standard``), to the filtered rows (``filter``),
    with smoothed inputs (``ewm``) and with a bias (``fem``). Dynamic models of others
    are fitted by least squares to the same days. All are scored on the held-out days.

    Parameters
    ----------
    poa_global : Series or DataFrame
        Irradiance in the plane of the array [W/m²], or a frame with all columns.
    temp_air, wind_speed, temp_module : Series
        Further columns, see :func:`fit_fem`; omit them with a frame. [°C], [m/s], [°C]
    models : str or sequence of str
        Steady models; by default the five of the paper.
    comparators : str or sequence of str
        Some of ``"prilliman"``, ``"armstrong_hurley"``, ``"veldhuis"``, ``"barry"``
        (which needs ``longwave_down``) and ``"torres_lobera"``, the exact heat balance
        of Faiman's model (:func:`heat_balance`); all by default, () for none.
    method : str, default "least_squares"
        Method of ``models``, or ``"paper"``, see :func:`fit_fem`.
    resolutions : float or sequence of float, optional
        Steps of the means to compare at; a mean needs half of its rows. By default the
        record's own step. [s]
    holdout, calm_wind, offset, check_units
        See :func:`fit_fem`.
    **drivers : Series
        ``longwave_down`` or ``ir_down``, which a frame has among its columns. [W/m²]

    Returns
    -------
    Comparison

    Raises
    ------
    ValueError
        If the record is unusable, a column is missing, or a name is unknown.

    Notes
    -----
    If a model cannot be fitted, the table has an empty cell and ``notes`` the reason:
    with ``method="paper"`` a record may have too few calm averages or step changes.

    ``"prilliman"`` is slow at steps of seconds, 10 s per day at 1 s. Omit it from
    ``comparators``, or give a ``resolutions`` of a minute.

    References
    ----------
    .. [1] B. Herteleer et al., "Investigating methods to improve photovoltaic
       thermal models at second-to-minute timescales", 2022, Tables 4 and 5, Figs. 8
       and 9. :doi:`10.22541/au.166922866.68736478`

    Examples
    --------
    >>> from pvlib_fem import datasets
    >>> data = datasets.synthetic(days=8, step=300)
    >>> comparison = compare_models(data, models="faiman", comparators="prilliman")
    >>> comparison.best()
    'faiman'
    """
    chosen, others = names_of(models), names_of(comparators)
    check_names(chosen, others, method)
    given = dict(zip(COLUMNS, (poa_global, temp_air, wind_speed, temp_module)))
    finest = as_record(**columns_of(given | by_own_names(drivers)))
    finest, faults = screened(finest, check_units=check_units)
    notes, coefficients = [*faults.notes], {}
    rows: dict = {}
    steps: list = sorted(seconds_of(resolutions)) or [None]
    for step in steps:
        record, out = finest, holdout
        if step is not None:
            record, out = coarser_record(finest, holdout, float(step))
        how: dict[str, Any] = dict(method=method, calm_wind=calm_wind, offset=offset)
        case = Case(record, out, notes)
        for name in chosen:
            case.model(name, **how)
        for name in others:
            case.other(name)
        rows |= {(case.resolution, *key): row for key, row in case.rows.items()}
        coefficients |= {(case.resolution, *k): v for k, v in case.coefficients.items()}
    table = pd.DataFrame.from_dict(rows, orient="index")
    levels = ["resolution", "model", "step"]
    table.index = pd.MultiIndex.from_tuples(table.index, names=levels)
    return Comparison(table, coefficients, tuple(dict.fromkeys(notes)), method)


def columns_of(given: dict) -> dict:
    """The columns of a frame in place of the first, or those that are given."""
    frame, known = given["poa_global"], (*COLUMNS, LONGWAVE)
    if unknown := [name for name in given if name not in known]:
        raise ValueError(
            f"no model uses {', '.join(unknown)}; they use {', '.join(known)}"
        )
    if not isinstance(frame, pd.DataFrame):
        if missing := [name for name in COLUMNS if given[name] is None]:
            raise ValueError(f"{no_columns(missing)}; give all of {', '.join(COLUMNS)}")
        return given
    more = [name for name, column in given.items() if column is not None]
    if more := more[1:]:
        raise ValueError(
            f"{', '.join(more)} given in addition to a frame; give the frame alone, "
            "with all columns, or its columns one by one"
        )
    there = with_aliases(frame)
    return {name: there[name] for name in known if name in there}


def seconds_of(resolutions: Any) -> list[float]:
    """Resolutions as a list; numbers of seconds, and no durations."""
    if resolutions is None:
        return []
    given = [resolutions] if np.ndim(resolutions) == 0 else [*resolutions]
    if wrong := [one for one in given if not (is_number(one) and one > 0)]:
        raise ValueError(
            f"resolution {wrong[0]!r} must be a positive number of seconds"
        )
    return given


def names_of(names: Any) -> Any:
    return (names,) if isinstance(names, str) else tuple(names)


def check_names(models: Any, comparators: Any, method: str) -> None:
    if not models and not comparators:
        raise ValueError("there is nothing to compare; name models or comparators")
    for given, known, what in (
        (models, tuple(STEADY_MODELS), "models"),
        (comparators, (*COMPARATORS, BALANCE), "comparators"),
        ((method,), METHODS, "methods"),
    ):
        if unknown := [name for name in given if name not in known]:
            raise ValueError(
                f"unknown {what} {', '.join(map(repr, unknown))}; they are "
                f"{', '.join(known)}"
            )


def coarser_record(record: Any, holdout: Any, step: Any) -> Any:
    """A record and its held-out rows as means over longer steps."""
    index = record.index
    usual = usual_step(index)
    if step < usual:
        raise ValueError(
            f"resolution {step:g} s is finer than the record's {usual:g} s; give "
            "coarser ones"
        )
    grid = pd.Timedelta(seconds=step)
    frame = record.inputs.frame().resample(grid)
    data = frame.mean().where(frame.count() >= PRESENT * step / usual)
    if holdout is not None:
        out = pd.Series(record.rows(holdout) * 1.0, index)
        holdout = out.resample(grid).max() > 0
    return as_record(**dict(data.items())), holdout


class Case:
    """Fit and score models on one record at one resolution."""

    def __init__(self, record: Any, holdout: Any, notes: list) -> None:
        self.record, self.notes = record, notes
        values = [self.record[name] for name in COLUMNS]
        rows = {part: np.asarray(inside(*values)) for part, inside in PARTS.items()}
        out = held_out(self.record, rows["day"], holdout, notes)
        self.frame = Frame.from_record(record, rows["day"], out)
        self.kept, self.train = ~out, self.frame.counts
        self.parts = {part: there & out for part, there in rows.items()}
        self.resolution = usual_step(self.record.index)
        self.rows, self.coefficients = {}, {}

    def model(self, name: str, method: Any, calm_wind: float, offset: Any) -> None:
        """Fit and score every step of one steady model."""
        target, record = thermal_model(name, "ewm"), self.record
        try:
            if method == "paper":
                rows = (self.train, self.kept)
                stages = paper_stages(target, record, *rows, calm_wind, offset, [])
            else:
                _, stages, _ = stages_of(self.frame, target)
        except ValueError as error:
            self.failed(name, error, STEPS)
            return
        for step, (model, values) in stages.items():
            self.add(name, step, model.temperature(record.inputs, values), values)

    def other(self, name: str) -> None:
        """Fit and score a comparator, which has only the last step."""
        try:
            if name == BALANCE:
                self.balance()
                return
            comparator = COMPARATORS[name]
            columns = self.record.inputs.columns
            needed = (*COLUMNS[:3], *comparator.columns)
            if missing := [column for column in needed if column not in columns]:
                names = ", ".join(missing)
                self.notes.append(f"{name} is not fitted: it needs {names}")
                return
            *inputs, module = (
                pd.Series(columns[column], self.record.index)
                for column in (*needed, "temp_module")
            )
            values = fitted(comparator, inputs, module, self.train)
            answer = comparator.function(*inputs, **values).to_numpy()
        except ValueError as error:
            self.failed(name, error, (FITTED,))
        else:
            self.add(name, FITTED, answer, values)

    def balance(self) -> None:
        target = thermal_model("faiman", "balance")
        _, stages, _ = stages_of(self.frame, target)
        model, values = stages[FITTED]
        answer = model.temperature(self.record.inputs, values)
        self.add(BALANCE, FITTED, answer, values)

    def failed(self, name: str, error: Any, steps: Any) -> None:
        self.notes.append(f"{name} at {self.resolution:g} s: {error}")
        for step in steps:
            self.rows[name, step] = self.scored(np.full(len(self.kept), np.nan))

    def add(self, name: str, step: Any, temperature: Any, values: Any) -> None:
        self.rows[name, step] = self.scored(temperature)
        self.coefficients[name, step] = values

    def scored(self, temperature: Any) -> Any:
        """Scores of a temperature on held-out rows, separately for day and night."""
        reading, row = self.record["temp_module"], {}
        for part, there in self.parts.items():
            suffix = "" if part == "day" else f"_{part}"
            for name, score in SCORES.items():
                row[f"{name}{suffix}"] = score(reading[there], temperature[there])
        both = np.isfinite(reading + temperature) & self.parts["day"]
        return {**row, "points": int(both.sum())}
