"""Fit a record in files: each pass reads its rows, and none is held in memory."""

from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem._fitting.daily import DailySums
from pvlib_fem._fitting.fem_fit import FemFit
from pvlib_fem._fitting.fit_stages import (
    flatness,
    minima,
    planned_stages,
    stages_of,
)
from pvlib_fem._fitting.frame_rows import Frame
from pvlib_fem._fitting.holdout import NONE_OUT, days_out
from pvlib_fem._fitting.least_squares_fit import fit_source
from pvlib_fem._fitting.parquet_rows import Files, first_pass, screened_for
from pvlib_fem._fitting.search import as_searched, natural_coefficients
from pvlib_fem._fitting.streamed_lags import means_note
from pvlib_fem._record.file_summary import Summary
from pvlib_fem._record.filters import counted
from pvlib_fem._record.parquet import ParquetRecord, as_source, write_parquet
from pvlib_fem._statistics.leastsquares import Minimum
from pvlib_fem._stored import saved
from pvlib_fem._thermal.model import ThermalModel
from pvlib_fem.scores import GAMMA
from pvlib_fem.types import FilePath


class NotHeldError(AttributeError, ValueError):
    """A fit of files does not hold this attribute in memory."""


@dataclass(frozen=True, eq=False)
class FileFit(FemFit):
    """
    A :class:`FemFit` of a record in files that holds no row in memory.

    ``record``, ``holdout`` and the pictures show means over a minute or more;
    :meth:`write_residual` writes the residual of all rows.
    """

    files: Files = field(kw_only=True, repr=False)

    def __post_init__(self) -> None:
        vars(self).pop("residual")

    def __getattr__(self, name: str) -> None:
        if name == "residual":
            raise NotHeldError(
                "the residual of a fit of files is not held in memory; write it with "
                "fit.write_residual('residual.parquet')"
            )
        raise AttributeError(f"{type(self).__name__!r} has no attribute {name!r}")

    @cached_property
    def summary(self) -> Summary:
        """Size, times and gaps of the record."""
        return self.files.summary

    @property
    def step(self) -> float:
        """Usual time between rows. [s]"""
        return self.files.step

    @property
    def wind(self) -> float:
        """Mean wind speed of the record. [m/s]"""
        return self.files.wind

    def write_residual(self, path: FilePath) -> None:
        """
        Write measured minus modelled temperature of all rows as Parquet.

        Parameters
        ----------
        path : str or path-like
            File to write, with the times as its index and the column ``residual`` [K].
            A failed write leaves no file.
        """
        model = self.thermal_model
        residuals = self.files.residuals(model, model.completed(self.coefficients))
        write_parquet(path, residuals, "residual")

    def on_means(self) -> FemFit:
        """The fit on means over a minute or more, for pictures."""
        own = {one.name: getattr(self, one.name) for one in own_fields()}
        model = self.thermal_model
        record: Any = self.record
        inputs = model.with_drivers(record.inputs)
        modelled = model.temperature(inputs, model.completed(self.coefficients))
        residual = pd.Series(record["temp_module"] - modelled, record.index)
        fit = FemFit(**own, residual=residual.rename("residual"))
        vars(fit)["summary"] = self.summary
        return fit

    def plot(self, ax: Any = None, when: str | slice | None = None) -> Any:
        """Plot means over a minute or more, see :meth:`FemFit.plot`."""
        return self.on_means().plot(ax, when)

    def to_html(
        self, path: FilePath | None = None, title: str = "", gamma: float = GAMMA
    ) -> str:
        """HTML page with means over a minute or more, see :meth:`FemFit.to_html`."""
        from pvlib_fem._report.fit_page import fit_page

        return saved(fit_page(self.on_means(), title, gamma), path)


def own_fields() -> list:
    return [one for one in fields(FemFit) if one.name != "residual"]


def in_files(data: Any, model: ThermalModel) -> ParquetRecord:
    """
    A data set as the source of a fit, without wind if the model needs none.

    Parameters
    ----------
    data : ParquetRecord, pyarrow.dataset.Dataset, str or path-like
        Files, or where they are, as of :func:`pvlib_fem.open_parquet`.
    model : ThermalModel
        The model to fit.

    Returns
    -------
    ParquetRecord
        Its ``wind_speed`` is 0 if the files have none.

    Raises
    ------
    ValueError
        If the files have no ``wind_speed`` and the model needs it.
    """
    source = as_source(data)
    if "wind_speed" in {*source.columns, *source.partial}:
        return source
    model.refuse_without_wind(source.columns)
    return source.without("wind_speed")


def fit_files(
    source: ParquetRecord,
    target: ThermalModel,
    holdout: pd.Series | None,
    night: bool,
    limits: Any,
    check_units: bool,
) -> FileFit:
    """
    Fit a record in files by least squares.

    Parameters
    ----------
    source : ParquetRecord
        The files.
    target : ThermalModel
        The model to fit.
    holdout : pandas.Series of bool, shape (days,), or None
        Days to hold out; None for the default.
    night : bool
        Whether night rows count, too.
    limits : Limits or None
        Thresholds of the screening; None for the defaults.
    check_units : bool
        Refuse columns that look to be in another unit.

    Returns
    -------
    FileFit
        A result without rows in memory.

    Raises
    ------
    ValueError
        If the record is unusable, or ``holdout`` has other than whole days.
    """
    screened = screened_for(source, target, limits, check_units)
    files, notes = first_pass(screened, target, night), list(screened.notes)
    return fit_in_files(files.without(dates_out(files, holdout, notes)), target, notes)


def fit_in_files(files: Files, target: ThermalModel, notes: list) -> FileFit:
    """
    Fit a record in files on the days that are not held out.

    Parameters
    ----------
    files : Files
        From :func:`first_pass`, with the held-out days.
    target : ThermalModel
        The model to fit.
    notes : list of str
        Notes on the rows; the notes on the fit are appended.

    Returns
    -------
    FileFit
        A result without rows in memory.
    """
    return fit_source(InFiles(files), target, notes)


def dates_out(files: Files, holdout: pd.Series | None, notes: list) -> np.ndarray:
    """Dates of the held-out days: the given ones, or the default."""
    if holdout is None:
        out = files.dates[days_out(files.dates, files.rows)]
    else:
        out = given_days(holdout)
    if not files.rows[np.isin(files.dates, out)].any():
        notes.append(NONE_OUT)
    return out


def given_days(holdout: pd.Series) -> np.ndarray:
    """
    Dates of the held-out days that a user chose.

    Parameters
    ----------
    holdout : pandas.Series of bool, shape (days,)
        True for held-out days, with a DatetimeIndex of midnights.

    Returns
    -------
    numpy.ndarray of int, shape (n,)
        Days since 1970-01-01 in the zone of the index.

    Raises
    ------
    ValueError
        If it is no such Series, or a time is not a midnight.
    """
    wrong = not isinstance(holdout, pd.Series) or holdout.dtype != bool
    if wrong or not isinstance(holdout.index, pd.DatetimeIndex):
        raise ValueError(
            "holdout of a record in files must be a boolean Series on days, True where "
            "held out, such as pd.Series(True, pd.date_range('2024-07-01', periods=7))"
        )
    local = holdout.index.tz_localize(None)
    if (local != local.normalize()).any():
        raise ValueError(
            f"holdout has the time {local[local != local.normalize()][0]}; of a record "
            "in files whole days are held out"
        )
    return local[holdout.to_numpy()].to_numpy().astype("M8[D]").astype(int)


@dataclass(frozen=True, eq=False)
class InFiles:
    """
    The rows of files as the source of a fit.

    Steps that do not depend on each other share each pass. They begin at the minimum
    of a fit to means over a minute or more.
    """

    files: Files
    kind = FileFit

    @property
    def count(self) -> Any:
        """How many rows are fitted."""
        return self.files.count

    @property
    def night(self) -> bool:
        return self.files.night

    @property
    def step(self) -> Any:
        """Usual time between rows. [s]"""
        return self.files.step

    @property
    def wind(self) -> Any:
        """Mean wind speed of the record. [m/s]"""
        return self.files.wind

    def search_start(self, target: ThermalModel) -> dict:
        """Start of each step's search: the minimum on means, or the default start."""
        means, out = self.files.means, np.isin(self.files.means.dates, self.files.out)
        rows = np.array(counted(means.inputs.columns, self.night))
        rows &= means.complete_rows(target.drivers)
        try:
            frame = Frame.from_record(means, rows, out, self.night)
            stages = stages_of(frame, target)[1]
        except ValueError:  # too few means count, but rows may be enough
            stages = {}
        usual = {name: row.start for name, row in target.parameters.items()}
        return {
            name: as_searched(*stages[name]) if name in stages else usual
            for name, *_ in planned_stages(target)
        }

    def minima(
        self, steps: list, starts: dict, final: bool
    ) -> tuple[dict, Minimum, dict]:
        """Models and coefficients of some steps, the last minimum, and the starts."""
        by_step = minima(self.files, steps, starts, flatness(steps, final))
        stages = {
            n: (model, natural_coefficients(model, by_step[n][1])[0])
            for n, model, *_ in steps
        }
        return stages, by_step[steps[-1][0]][0], starts

    def result_parts(
        self, requests: dict, last: str, names: tuple
    ) -> tuple[DailySums, dict]:
        """Daily sums of the last step, and the attributes of a result from the rows."""
        files, means = self.files, self.files.means
        table, daily = files.scores_and_sums(requests, last, names)
        out = pd.Series(np.isin(means.dates, files.out), means.index, name="holdout")
        return daily, dict(
            scores=table,
            residual=None,
            train_days=int((files.rows[files.fitted] > 0).sum()),
            test_days=int((files.rows[~files.fitted] > 0).sum()),
            holdout=out,
            record=means,
            files=files,
        )

    def rows_for(self, model: ThermalModel) -> Files:
        """The source of the rows of a model."""
        return self.files

    def notes(self, target: ThermalModel) -> list:
        """Notes on results that come from means instead of rows."""
        return means_note(target, self.files)
