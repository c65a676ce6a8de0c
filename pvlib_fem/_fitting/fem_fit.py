"""The result of a fit."""

import warnings
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Self

import numpy as np
import pandas as pd
from scipy.stats import t as student

from pvlib_fem._fitting.daily import DailySums, correlation
from pvlib_fem._fitting.fit_files import fit_content, fit_parts
from pvlib_fem._fitting.holdout import held_out
from pvlib_fem._fitting.periods import through_time
from pvlib_fem._modelchain import CELL, FIT, FITS, DynamicCellTemperature, fit_in
from pvlib_fem._record.column_names import COLUMNS, printable, with_aliases
from pvlib_fem._record.file_summary import Summary, summary_of
from pvlib_fem._record.inputs import Record
from pvlib_fem._stored import Stored, opened, saved, written
from pvlib_fem._thermal.model import ThermalModel, thermal_model
from pvlib_fem._thermal_parameters.parameter_table import thermal_parameters
from pvlib_fem.effects import EffectLike
from pvlib_fem.scores import GAMMA
from pvlib_fem.types import FilePath


@dataclass(frozen=True, eq=False)
class FemFit:
    """
    Fitted coefficients of a module, their errors and scores.

    ``print(fit)`` is the report. ``coefficients`` unpack into
    :func:`pvlib_fem.fem_temperature` (``ewm``, and ``steady`` with a ``tau`` near 0)
    or :func:`pvlib_fem.heat_balance` (``balance``).

    Attributes
    ----------
    model, dynamics, method : str
        Arguments of :func:`fit_fem`.
    effects : tuple of Effect
        Physical effects that were fitted in addition to the model.
    coefficients : dict
        Coefficients of the model and its effects, ``tau`` [s] or ``capacity``
        [J/(m² K)], and ``bias`` [K].
    stderr : dict
        Standard errors of the coefficients, from the spread between training days, the
        autocorrelation of the residual and coarse steps of the wind; NaN if unknown,
        see ``notes``.
    scores : DataFrame
        Errors after each step on daytime rows: ``standard`` (steady, fitted to all
        rows), ``filter`` (steady, fitted to the filtered rows), ``ewm`` (with the
        dynamics) and ``fem`` (with the bias), then a row for each effect; the last
        row is this fit. [K]
    residual : Series or None
        Measured minus modelled temperature on all rows. A fit that was read from a file
        holds no rows: ``residual``, ``holdout`` and ``record`` are None. [K]
    at_bound : tuple of str
        Coefficients that ended at a bound of their range.
    converged : bool
        Whether the search ended at a minimum.
    notes : tuple of str
        Warnings and explanations for the reader of the numbers.
    train_days, test_days : int
        Days with daytime rows in either part.
    holdout : Series
        Boolean mask of the held-out rows.
    record : Record
        The checked record.
    night : bool
        Whether night rows count, too.
    base : dict or None
        Coefficients that give the effects the temperature of the module and its loss:
        of the step before the effects, or of this fit if an effect scales the loss;
        None without effects.
    fixed : dict
        Coefficients that were held and not fitted; their error is 0.
    cell : dict
        ``deltaT`` or ``k_bs_c`` from the back of the module to its cells, as given to
        :meth:`to_json`; empty if unknown.
    daily : DailySums or None
        Daily sums, from which :meth:`through_time` makes its table; None for a fit
        that was read from a file or has ``method="paper"``.
    """

    model: str
    dynamics: str
    method: str
    effects: tuple
    coefficients: dict
    stderr: dict
    scores: pd.DataFrame
    residual: pd.Series | None = field(repr=False)
    at_bound: tuple
    converged: bool
    notes: tuple
    train_days: int
    test_days: int
    holdout: pd.Series | None = field(repr=False)
    record: Record | None = field(repr=False)
    night: bool = False
    base: dict | None = None
    fixed: dict = field(default_factory=dict)
    cell: dict = field(default_factory=dict)
    daily: DailySums | None = field(default=None, repr=False)

    @cached_property
    def summary(self) -> Summary:
        """Size, times and gaps of the record."""
        return summary_of(self.record)

    @cached_property
    def correlation(self) -> pd.DataFrame:
        """Correlations of fitted coefficients, by the jackknife over days."""
        return correlation(self.daily, self.stderr)

    @property
    def covariance(self) -> pd.DataFrame:
        """
        Covariance of the fitted coefficients.

        Its diagonal holds the squares of ``stderr``; its correlations are from the
        jackknife over days. It is empty if the fit has no errors.
        """
        error = pd.Series(self.stderr)[self.correlation.index]
        return self.correlation.mul(error, axis=0).mul(error, axis=1)

    @property
    def step(self) -> float:
        """Usual time between rows. [s]"""
        return self.summary.step if self.record is None else self.record.inputs.step

    @property
    def wind(self) -> float:
        """Mean wind speed of the record; 0 without a wind column. [m/s]"""
        if self.record is None:
            raise ValueError(
                "a fit that was read from a file has no rows and no mean wind; fit "
                "them again"
            )
        return float(np.nanmean(self.record["wind_speed"]))

    @property
    def thermal_model(self) -> ThermalModel:
        """The steady model, dynamics and effects that were fitted."""
        return thermal_model(
            self.model, self.dynamics, self.effects, self.base, self.fixed
        )

    def predict(
        self,
        poa_global: pd.Series | pd.DataFrame,
        temp_air: pd.Series | None = None,
        wind_speed: pd.Series | None = None,
        **drivers: pd.Series,
    ) -> pd.Series:
        """
        Module temperature with these coefficients.

        Parameters
        ----------
        poa_global : Series or DataFrame
            Irradiance [W/m²]; or a frame of weather with the columns that the model
            needs.
        temp_air, wind_speed : Series, optional
            [°C], [m/s]; omit them with a frame. A model without wind needs no
            ``wind_speed``.
        **drivers : Series
            Drivers of the effects.

        Returns
        -------
        Series
            [°C]

        Raises
        ------
        ValueError
            If a column that the model needs is missing.
        """
        usual = [poa_global, temp_air, wind_speed]
        if isinstance(poa_global, pd.DataFrame):
            needed = self.thermal_model.usual
            columns = with_aliases(poa_global, needed) | drivers
            usual = [columns[n] if n in needed else None for n in COLUMNS[:3]]
            wanted = self.thermal_model.drivers
            drivers = {name: columns[name] for name in wanted if name in columns}
        return self.thermal_model.predict(
            *usual, coefficients=self.coefficients, **drivers
        )

    def confidence_interval(self, level: float = 0.95) -> pd.DataFrame:
        """
        Confidence intervals by Student's t over the training days.

        Parameters
        ----------
        level : float, default 0.95

        Returns
        -------
        DataFrame
            ``lower`` and ``upper`` by coefficient; NaN without an error.
        """
        if not 0 < level < 1:
            raise ValueError(f"level = {level} must be between 0 and 1, such as 0.95")
        factor = student.ppf(0.5 + level / 2, max(self.train_days - 1, 1))
        value, error = pd.Series(self.coefficients), pd.Series(self.stderr)
        return pd.DataFrame(
            {"lower": value - factor * error, "upper": value + factor * error}
        )

    def through_time(
        self, freq: str = "MS", coefficients: str | Iterable[str] | None = None
    ) -> pd.DataFrame:
        """
        Each coefficient per month or any other period, with its error.

        The table is computed from the daily sums of the fit, without a further pass
        over the record. Only fitted rows count.

        Parameters
        ----------
        freq : str, default "MS"
            Periods, as an offset of pandas that is a day or longer: ``"MS"`` months,
            ``"QS"`` quarters, ``"W-MON"`` weeks, ``"14D"``.
        coefficients : str or sequence of str, optional
            Fitted coefficients that vary from period to period; the others keep the
            value of the whole fit. By default all coefficients of the model vary, and
            coefficients of effects do not. A single varying coefficient has a smaller
            error, which is right only if the others do not change.

        Returns
        -------
        DataFrame
            A row for each ``coefficient`` and ``start`` of a period, which are its
            index: ``value``, its ``stderr``, ``lower`` and ``upper`` of the 95 %
            interval (Student's t over the days or weeks), all in ``unit``; ``days``,
            the number of fitted days; and ``why``, empty unless a number is NaN. A
            number is NaN below 5 days, or if the period does not determine it. If a
            coefficient of the steady model varies, the table also has ``r_eq``
            [K m²/W], the over-temperature per irradiance at the mean wind of sunny
            hours. The errors of u0 and u1, or of k and d, are correlated; ``r_eq`` is
            better determined.

        Raises
        ------
        ValueError
            If the fit keeps no sums (it was read from a file, or is by
            ``method="paper"``), ``freq`` is no period, or a name was not fitted.

        Notes
        -----
        Each period is linearised about the fit: in the resistance at each wind, the
        bias, the mean age of the past and the coefficients of effects. So large gains
        are found, too. Without noise, for an over-temperature that steps by -20 to
        20 %, u0 and u1 (or k, d) are within 0.2 %, tau within 0.1 %, and a capacity
        within 1.1 % at 15 min. For a step of 50 % they are within 0.4, 0.1 and 5 %. A
        u1 that alone falls by 40 % is within 2 %.

        Errors are from the jackknife over days (CR3, as in the fit), or over weeks if
        a period has 8 of them. They do not include disturbances that last longer. The
        guide has the measured coverage of the intervals.

        Examples
        --------
        >>> import pvlib_fem as fem
        >>> data = fem.datasets.synthetic(days=90, step=900)
        >>> names = ["poa_global", "temp_air", "wind_speed", "temp_module"]
        >>> columns = [data[name] for name in names]
        >>> fit = fem.fit_fem(*columns, model="faiman", dynamics="balance")
        >>> table = fit.through_time()
        >>> table["value"].loc["u0"].round(1).tolist()  # June to August
        [25.0, 25.1, 25.2]
        """
        return through_time(self, freq, coefficients)

    def thermal_parameters(
        self,
        data: pd.DataFrame | None = None,
        *,
        holdout: pd.Series | None = None,
        typical_year: pd.DataFrame | None = None,
        wind_height: float | None = None,
        exponent: float = 1 / 7,
        surface_tilt: float | None = None,
        module_efficiency: float = 0.2,
        absorptance: float = 0.9,
        deltaT: float | None = None,
        with_bias: bool = True,
    ) -> pd.DataFrame:
        """
        The fit in the conventions of pvlib, PVsyst, SAM and the IEC.

        Parameters
        ----------
        data : DataFrame, optional
            The record, with the columns of the fit; by default the fit's own. A fit
            that was read from a file holds no record. Without a record, these rows have
            no value: ``nmot`` by IEC 61853-2, ``prilliman``, ``held-out error``,
            ``T98``, time constants of means, and models without wind (``ross``,
            ``pvsyst, no wind``). [W/m²], [°C], [m/s]
        holdout : Series of bool, optional
            Held-out rows of ``data``; by default the default of :func:`fit_fem`. The
            unit mass is fitted to the other rows.
        typical_year : DataFrame, optional
            Weather of a year for T98: ``poa_global`` [W/m²] in the plane of the
            modules, ``temp_air`` [°C], ``wind_speed`` [m/s] at the height of the
            anemometer, and the drivers of the fit's effects.
        wind_height : float, optional
            Height of the anemometer above ground; rows for wind at 10 m need it. [m]
        exponent : float, default 1/7
            Exponent of ``WS(10 m) = WS (10 m / wind_height)**exponent``.
        surface_tilt : float, optional
            Tilt of the module, for the conditions. [°]
        module_efficiency : float, default 0.2
            Efficiency of the module, for the parameters of PVsyst and SAM. [-]
        absorptance : float, default 0.9
            Absorptance of the module: PVsyst's ``alpha_absorption`` and SAM's
            ``transmittance_absorptance``. [-]
        deltaT : float, optional
            Cell minus back temperature at 1000 W/m². By default the value in the
            fit's file, or 0 with a note. [K]
        with_bias : bool, default True
            Whether the fit's bias is part of the module's temperature. Other tools
            have no bias, so it is added to the over-temperature at 800 W/m². False
            ignores it as an offset of the thermometer. Measured numbers, such as T98
            of the record, always include it.

        Returns
        -------
        DataFrame
            A row for each ``convention`` and ``parameter``, which are its index:
            ``value`` in ``unit``; its ``stderr``, by the delta method from the
            covariance of the fit's coefficients unless the guide says otherwise;
            ``low`` and ``high`` of the 95 % range; ``mismatch`` [K], the largest
            difference between that model's temperature and the fit's from 400 to 1000
            W/m² at the winds in ``conditions``; ``of`` (``"module"`` or ``"cell"``),
            ``conditions``, ``equation``, ``source``; and ``note``, which says why a
            number is NaN and what else limits it. Parameters have the names
            of pvlib's arguments, so that ``table.loc["faiman", "value"]`` unpacks into
            :func:`pvlib.temperature.faiman`.

        Raises
        ------
        ValueError
            If an argument is out of range, or a column is missing.

        Notes
        -----
        Other tools have no effects. With a record, the mean effect over fitted rows,
        weighted by irradiance squared, is added like the bias; without a record effects
        are omitted. ``conditions`` name them. A ``unit_mass`` of 20 kg/m² or more is
        NaN: there Prilliman's rate is zero or negative in still air.

        Examples
        --------
        >>> import pvlib
        >>> import pvlib_fem as fem
        >>> data = fem.datasets.synthetic(days=20, step=300, seed=1)
        >>> fit = fem.fit_fem(data, model="faiman", dynamics="balance")
        >>> table = fit.thermal_parameters()
        >>> round(float(table.loc[("nmot", "of the fit"), "value"]), 1)
        43.2
        >>> faiman = table.loc["faiman", "value"]
        >>> round(float(pvlib.temperature.faiman(800.0, 20.0, 1.0, **faiman)), 1)
        43.2
        """
        return thermal_parameters(
            self,
            out_of,
            data,
            holdout,
            typical_year,
            wind_height,
            exponent,
            surface_tilt,
            module_efficiency,
            absorptance,
            deltaT,
            with_bias,
        )

    def temperature_model(
        self, weather: pd.DataFrame | None = None, **options: Any
    ) -> DynamicCellTemperature:
        """
        These coefficients as a temperature model for pvlib's ModelChain.

        Parameters
        ----------
        weather : DataFrame, optional
            Weather of the run, with the columns that the effects need.
        **options
            ``deltaT`` or ``k_bs_c`` from the back of the module to its cells, and
            drivers by name, see :class:`DynamicCellTemperature`. Without ``deltaT`` or
            ``k_bs_c``, here or in the file of the fit, cells have the temperature at
            the sensor, and a warning says so.

        Returns
        -------
        DynamicCellTemperature
        """
        cell = {name: options.pop(name) for name in CELL if name in options}
        cell = cell or self.cell
        if not cell:
            warnings.warn(
                "deltaT = 0 K is taken: the cells as warm as the place where the "
                "sensor was. Behind an open rack they are some 3 K warmer at 1000 "
                "W/m², deltaT=3.0; give deltaT=0.0 if the sensor measured the cells",
                stacklevel=2,
            )
        if weather is not None:
            columns = with_aliases(weather, ())
            wanted = self.thermal_model.drivers
            options = {n: columns[n] for n in wanted if n in columns} | options
        return DynamicCellTemperature(
            self.model,
            self.dynamics,
            self.coefficients,
            effects=self.effects,
            base=self.base,
            **cell,
            **options,
        )

    def plot(self, ax: Any = None, when: str | slice | None = None) -> Any:
        """
        Measured and modelled temperature, and below them the residual.

        Parameters
        ----------
        ax : matplotlib Axes, optional
        when : str or slice, optional
            A date or a part of the index; by default the most variable held-out day.

        Returns
        -------
        matplotlib Axes
        """
        if self.record is None:
            raise ValueError(
                "a fit that was read from a file has no rows to plot; fit them again"
            )
        from pvlib_fem import plotting

        return plotting.plot_fit(self, ax, when)

    def to_html(
        self, path: FilePath | None = None, title: str = "", gamma: float = GAMMA
    ) -> str:
        """
        The fit with pictures as one self-contained HTML file.

        Parameters
        ----------
        path : str or path-like, optional
            File to write.
        title : str, optional
            Title of the page.
        gamma : float, default -0.0035
            Temperature coefficient of power, to convert K to yield. [1/K]

        Returns
        -------
        str
        """
        from pvlib_fem._report.fit_page import fit_page

        return saved(fit_page(self, title, gamma), path)

    def _repr_html_(self) -> str:
        from pvlib_fem._report.fit_page import brief

        return brief(self)

    def to_json(self, path: FilePath | None = None, **cell: float) -> str:
        """
        The fit as JSON, which :meth:`from_json` reads.

        All numbers keep their bits. The file has neither the rows of the record nor
        their daily sums, so store the table of :meth:`through_time` separately.

        Parameters
        ----------
        path : str or path-like, optional
            File to write.
        **cell
            ``deltaT`` [K] or ``k_bs_c`` [K m²/W] from the back of the module to
            its cells, to store with the coefficients, see
            :class:`DynamicCellTemperature`.

        Returns
        -------
        str
        """
        return written(FIT, self.content(**cell), path)

    def content(self, **cell: float) -> dict:
        """Content of a file of the fit."""
        return fit_content(self, cell)

    @classmethod
    def from_json(
        cls, path: FilePath, effects: EffectLike | Iterable[EffectLike] = ()
    ) -> Self:
        """
        The fit that :meth:`to_json` or the command ``pvlib-fem`` wrote.

        Parameters
        ----------
        path : str or path-like
            File of a fit, or of a loop, whose fit is taken.
        effects : Effect or sequence of these, optional
            Your own effects, of which the file has only name and settings.

        Returns
        -------
        FemFit
            Without the rows: ``record``, ``residual``, ``holdout`` and ``daily`` are
            None.

        Raises
        ------
        ValueError
            If the file is of another kind or version, or a number is missing or
            invalid; the message names the key.
        """
        with opened(path, FITS) as stored:
            return cls.stored(fit_in(stored), effects)

    @classmethod
    def stored(
        cls, content: Stored, own: EffectLike | Iterable[EffectLike] = ()
    ) -> Self:
        """The fit of a part of a file."""
        attributes, computed = fit_parts(content, own)
        fit = cls(**attributes, residual=None, holdout=None, record=None)
        vars(fit).update(computed)
        return fit

    def __str__(self) -> str:
        from pvlib_fem._report.fit_text import lines

        return printable("\n".join(lines(self)), "\n")


def out_of(record: Record, counts: np.ndarray, holdout: pd.Series | None) -> np.ndarray:
    """Mask of the held-out rows: the given ones, or the default."""
    return held_out(record, counts, holdout, [])


def of_rows(
    record: Record,
    temperature: np.ndarray,
    train: np.ndarray,
    test: np.ndarray,
    out: np.ndarray,
) -> dict:
    """
    The attributes of a result that come from rows in memory.

    Parameters
    ----------
    record : Record
        With ``temp_module``.
    temperature : numpy.ndarray, shape (rows,)
        Modelled temperature of the module. [°C]
    train, test : numpy.ndarray of bool, shape (rows,)
        Rows that count and are fitted, or held out.
    out : numpy.ndarray of bool, shape (rows,)
        All rows that are held out.

    Returns
    -------
    dict
        ``residual``, ``train_days``, ``test_days``, ``holdout`` and ``record`` of
        :class:`FemFit`.
    """
    residual = record["temp_module"] - temperature
    return dict(
        residual=pd.Series(residual, record.index, name="residual"),
        train_days=record.count_days(train),
        test_days=record.count_days(test),
        holdout=pd.Series(out, record.index, name="holdout"),
        record=record,
    )
