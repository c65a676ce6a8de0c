"""A physical effect: the terms that it adds to the equation, and its parameters."""

import inspect
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, fields, replace
from functools import cached_property, partial
from numbers import Real
from typing import Any

import numpy as np

from pvlib_fem._record.column_names import in_new_names
from pvlib_fem._record.inputs import Columns
from pvlib_fem._spelling import did_you_mean
from pvlib_fem.drivers import constants, own_constants, with_constants
from pvlib_fem.reasons import Reason

SOME = 5000  # rows of a record on which linearity is tested


@dataclass(frozen=True)
class Parameter:
    """
    One row of a parameter table.

    With ``share_of``, start and bounds are shares of the parameter of that name. The
    fit then varies the share, so that a bound which depends on the other parameter is
    constant.
    """

    start: float
    lower: float
    upper: float
    unit: str
    share_of: str | None = None

    @property
    def little(self) -> float:
        """Step of a finite difference: a small part of the range."""
        return 1e-4 * (self.upper - self.lower)


@dataclass(frozen=True, eq=False)
class Terms:
    """
    Terms that an effect adds to the five columns of the equation.

    ``capacity · dT/dt = heat − loss · (T − T_air)``,
    ``measured = T + gain · (T − T_air) + offset``.
    """

    heat: np.ndarray | float = 0.0  # [W/m²]
    loss: np.ndarray | float = 0.0  # [W/(m² K)]
    capacity: np.ndarray | float = 0.0  # [J/(m² K)]
    offset: np.ndarray | float = 0.0  # [K]
    gain: np.ndarray | float = 0.0  # share of the over-temperature read in addition [-]

    def plus(self, other: "Terms", times: float = 1.0) -> "Terms":
        """The sum of these terms and ``times`` the others."""
        return Terms(
            *(sum_of_columns(own, more, times) for own, more in self.paired(other))
        )

    def paired(self, other: "Terms") -> list[tuple]:
        """Pairs of equal columns of these terms and others."""
        names = [column.name for column in fields(Terms)]
        return [(getattr(self, name), getattr(other, name)) for name in names]

    @property
    def follows_temperature(self) -> bool:
        """Whether the module temperature scales any of them: not heat and offset."""
        return any(map(is_there, (self.loss, self.capacity, self.gain)))

    @property
    def rows(self) -> int:
        """Number of rows; 0 if all columns are numbers."""
        columns = (getattr(self, column.name) for column in fields(Terms))
        return max(len(column) if np.ndim(column) else 0 for column in columns)

    def is_near(self, other: "Terms") -> bool:
        """Whether these terms equal others within rounding errors."""
        return all(
            np.allclose(one, another, rtol=1e-6, atol=1e-9, equal_nan=True)
            for one, another in self.paired(other)
        )

    def part(self, rows: slice | np.ndarray) -> "Terms":
        """The terms on some of the rows."""
        columns = (getattr(self, column.name) for column in fields(Terms))
        return Terms(*(c[rows] if np.ndim(c) else c for c in columns))


def is_there(column: float | np.ndarray) -> bool:
    """
    Whether a column of terms is anything but the number 0.

    Parameters
    ----------
    column : float or array, shape (rows,)

    Returns
    -------
    bool
        True for any array.
    """
    return np.ndim(column) > 0 or column != 0.0


def sum_of_columns(
    own: float | np.ndarray, more: float | np.ndarray, times: float
) -> float | np.ndarray:
    """A column of terms plus ``times`` another; fast if one is the number 0."""
    if not is_there(more):
        return own
    more = times * more if is_there(times - 1.0) else more
    return own + more if is_there(own) else more


@dataclass(frozen=True, eq=False)
class Effect:
    """
    A physical effect: a function and a table.

    Parameters
    ----------
    name : str
    terms : callable
        Function from drivers, by position, and fitted parameters, by keyword only, to
        :class:`Terms`. It adds nothing if all parameters are at their start.
    parameters : dict of Parameter
    columns : tuple of str, optional
        Names of the columns of its drivers, in order; by default the names of the
        function's arguments.
    confounder : bool, default False
        Whether it is a function of irradiance, air temperature, wind and sun
        alone. Several such effects can look alike, so they are reported as a
        class.
    title : str, optional
        The part of physics that a model without it does not have, as a noun phrase.
    decided_by : str, optional
        A measurement that would distinguish it from its alternatives, as a phrase.
    settings : dict, optional
        Settings that it was made with, if its name alone does not define it.
    source : str, optional
        Which of several drivers it uses; printed as "from ...".
    confused_with : tuple of str, optional
        Other causes of the same residual: names of effects, or phrases.
    column : str, optional
        Name of the user's own column, for an effect that only follows that.
    variants : tuple of Effect, optional
        Variants by the available measurements, the best first. The first variant
        whose columns are there is tested. Without variants the effect has one form.
    make : callable, optional
        Function from ``settings``, by keyword, to the effect.
    prepare : callable, optional
        ``prepare(columns, rows)`` returns the effect with settings from a record's
        columns at ``rows``, which are those that may be used.
    scan : callable, optional
        ``scan(rest, tangents, columns, weeks, least)`` returns the effect with settings
        that the residual of a fit suggests, or None. ``rest`` is the residual and
        ``tangents`` a dict by name, both in K: first the parameters of
        ``scanned_from``, then all fitted coefficients. ``columns`` has the drivers of
        ``scanned_from``, and others that follow from the record's columns; ``weeks``
        is the number of each row's week, and ``least`` the least gain of a setting.
        [K] If the effect that it returns has a scan, this is done next, among settings
        near those that were found.
    scanned_from : Effect, optional
        The wide effect whose tangents the scan needs, if it is not this one.
    not_found : Reason
        Why it is not weighed if the scan finds nothing.
    turns : bool, default False
        Whether it is tried of planes only that turn about an axis.
    sensor_fault : str, optional
        Name of the sensor fault or change of mounting that has a time profile.
    dates : object, optional
        ``dates(**dates)`` returns the effect with dates, for one that has none yet.
    unseen_light : bool, default False
        Whether the irradiance sensor shows more or less light than the modules have.
        A reflection onto the modules looks the same.
    geometric : bool, default False
        Whether its law is the geometry of a plane or an obstacle, and thus exact: of a
        true effect no residual remains along the position of the sun.
    loses_light : bool, default False
        Whether it is light that the sensor or the modules lose from day to day, so that
        power or a clear sky deviates along its days.
    imitable : bool, default False
        Whether other causes can have its law, although it has a driver of its own.
    kind_of : str, optional
        Name of a more general effect, of which this is a special case.
    """

    name: str
    terms: Callable
    parameters: Mapping[str, Parameter]
    columns: tuple | None = None
    confounder: bool = False
    title: str = ""
    decided_by: str = ""
    settings: Mapping = field(default_factory=dict)
    source: str = ""
    confused_with: tuple = ()
    column: str = ""
    variants: tuple = ()
    make: Callable | None = None
    prepare: Callable | None = None
    scan: Callable | None = None
    scanned_from: "Effect | None" = None
    not_found: Reason = Reason.NO_WINDOW
    turns: bool = False
    sensor_fault: str = ""
    dates: Any = None
    unseen_light: bool = False
    loses_light: bool = False
    imitable: bool = False
    geometric: bool = False
    kind_of: str = ""

    @property
    def forms(self) -> "tuple[Effect, ...]":
        """The variants, the best first; the effect itself if it has none."""
        return self.variants or (self,)

    @property
    def constants(self) -> Mapping[str, float]:
        """Constants of its function and of its drivers, with their defaults."""
        values = {}
        for driver in self.drivers:
            values |= constants(driver)
        return values | own_constants(self.terms, besides=self.parameters)

    @property
    def unscanned(self) -> "Effect":
        """The effect with the settings that it has, for which no scan looks."""
        return replace(self, scan=None, scanned_from=None, make=None)

    def made(self, **settings: Any) -> "Effect":
        """
        The effect with other settings.

        Parameters
        ----------
        **settings
            The ``source`` of one of its variants, arguments of ``make``, and any of
            the constants of its function and its drivers.

        Returns
        -------
        Effect
        """
        effect, others = self, dict(settings)
        if self.variants and "source" in others:
            effect = self.from_source(others.pop("source"))
        own = inspect.signature(effect.make).parameters if effect.make else {}
        if mine := {name: others.pop(name) for name in own if name in others}:
            effect = effect.make(**mine)
        if taken := {name for form in effect.forms for name in form.constants}:
            forms = tuple(form.made(**form.own(others)) for form in effect.variants)
            effect = replace(effect.with_constants(others), variants=forms)
        if unknown := [name for name in others if name not in taken]:
            there = sorted({*own, *taken, *(["source"] if self.variants else [])})
            raise ValueError(
                f"{self.name} has no setting {', '.join(unknown)}"
                f"{did_you_mean(unknown, there)}; "
                + (f"it has {', '.join(there)}" if there else "it has none")
            )
        return effect

    def from_source(self, source: str) -> "Effect":
        """The variant with that source."""
        for form in self.variants:
            if form.source == source:
                return form
        sources = "; ".join(form.source for form in self.variants if form.source)
        raise ValueError(
            f"unknown source {source!r} of {self.name}; there are {sources}"
        )

    def estimated(self, source: str, column: str, confounder: bool = False) -> "Effect":
        """The variant whose driver is estimated from a source, as some column."""
        return replace(
            self,
            columns=(column,),
            confounder=confounder,
            settings={"source": source},
            source=source,
        )

    def own(self, settings: Mapping[str, Any]) -> dict[str, Any]:
        """Its own constants among some settings."""
        return {k: v for k, v in settings.items() if k in self.constants}

    def with_constants(self, settings: Mapping[str, Any]) -> "Effect":
        """The effect with its own constants among some settings."""
        given = self.own(settings)
        if not given:
            return self
        for name, value in given.items():
            if not isinstance(value, Real) or not np.isfinite(float(value)):
                raise ValueError(f"{self.name}: {name} = {value!r} must be a number")
        own = own_constants(self.terms, besides=self.parameters)
        terms = self.terms
        if mine := {name: given[name] for name in own if name in given}:
            terms = partial(terms, **mine)
            terms.__doc__ = self.terms.__doc__  # instead of functools.partial's
        return replace(
            self,
            terms=terms,
            columns=tuple(with_constants(driver, given) for driver in self.drivers),
            settings={**self.settings, **given},
        )

    @property
    def spec(self) -> str | dict[str, Any]:
        """Its name, or a dict with its settings, from which it is found again."""
        return {"name": self.name, **self.settings} if self.settings else self.name

    @cached_property
    def drivers(self) -> tuple[str, ...]:
        """Names of the columns that it needs."""
        names = self.columns
        if names is None:
            signature = inspect.signature(self.terms).parameters.values()
            names = tuple(p.name for p in signature if p.kind is not p.KEYWORD_ONLY)
        return tuple(in_new_names(dict.fromkeys(names)))

    def rows(self) -> dict[str, Parameter]:
        """Parameter rows by their names in a model."""
        return {f"{self.name}.{name}": row for name, row in self.parameters.items()}

    @property
    def start(self) -> dict[str, float]:
        """Starts of its parameters, at which it adds nothing, by names in a model."""
        return {name: row.start for name, row in self.rows().items()}

    def at(
        self, columns: Mapping[str, np.ndarray], coefficients: Mapping[str, float]
    ) -> Terms:
        """Terms with these coefficients of a model."""
        drivers = [columns[name] for name in self.drivers]
        own = {name: coefficients[f"{self.name}.{name}"] for name in self.parameters}
        return self.terms(*drivers, **own)

    def slopes(
        self, columns: Mapping[str, np.ndarray], coefficients: Mapping[str, float]
    ) -> dict[str, Terms]:
        """
        Slope of the terms by each parameter, by central differences.

        This is exact for effects that are linear in their parameters, as most are.
        """
        slopes = {}
        for name, row in self.rows().items():
            up, down = (
                self.at(columns, {**coefficients, name: coefficients[name] + change})
                for change in (row.little, -row.little)
            )
            difference = up.plus(down, -1.0)
            slopes[name] = Terms().plus(difference, 0.5 / row.little)
        return slopes


@dataclass(frozen=True, eq=False)
class LinearisedEffect:
    """A linear effect on one record, represented by its slopes."""

    effect: Effect
    units: Mapping  # slope of the terms by parameter

    def __getattr__(self, name: str) -> Callable | tuple[str, str]:
        return getattr(self.effect, name)

    def at(self, columns: Columns, coefficients: dict) -> Terms:
        """Terms with these coefficients, from the slopes."""
        whole = Terms()
        for name, row in self.effect.rows().items():
            whole = whole.plus(self.units[name], coefficients[name] - row.start)
        return whole

    def slopes(self, columns: Columns, coefficients: dict) -> Mapping:
        return self.units

    def on_rows(self, rows: Any) -> "LinearisedEffect":
        """The effect on a slice of the rows."""
        return LinearisedEffect(
            self.effect, {n: unit.part(rows) for n, unit in self.units.items()}
        )


@dataclass(frozen=True, eq=False)
class FixedTerms:
    """An effect with fixed coefficients, represented by its terms on a record."""

    effect: Effect
    terms: Terms
    units: Mapping

    def __getattr__(self, name: str) -> Callable | tuple:
        return getattr(self.effect, name)

    def at(self, columns: Columns, coefficients: dict) -> Terms:
        return self.terms

    def slopes(self, columns: Columns, coefficients: dict) -> Mapping:
        return self.units

    def on_rows(self, rows: Any) -> "FixedTerms":
        """The effect on a slice of the rows."""
        units = {name: unit.part(rows) for name, unit in self.units.items()}
        return FixedTerms(self.effect, self.terms.part(rows), units)


def with_known_terms(
    effect: Effect | FixedTerms | LinearisedEffect,
    columns: Columns,
    coefficients: dict,
    wanted: bool = True,
) -> FixedTerms | LinearisedEffect:
    """
    The effect with its terms and their slopes computed on columns.

    Parameters
    ----------
    effect : Effect, FixedTerms or LinearisedEffect
        Only an :class:`Effect` is changed.
    columns : Columns
        With the drivers of the effect.
    coefficients : dict
        Coefficients of the model by name.
    wanted : bool, default True
        Whether slopes are computed.

    Returns
    -------
    FixedTerms or LinearisedEffect
    """
    if isinstance(effect, (LinearisedEffect, FixedTerms)):
        return effect
    slopes = effect.slopes(columns, coefficients) if wanted else {}
    return FixedTerms(effect, effect.at(columns, coefficients), slopes)


def linearised(effect: Effect, columns: Columns) -> Any:
    """
    The effect by its slopes on these columns; a nonlinear one as it is.

    Linearity is tested at one point inside the bounds, on at most 10,000 rows if the
    terms of a row depend on that row alone.

    Parameters
    ----------
    effect : Effect or LinearisedEffect
    columns : Columns
        With the drivers of the effect.

    Returns
    -------
    LinearisedEffect or Effect
    """
    if isinstance(effect, LinearisedEffect):
        return effect
    rows, start, units = effect.rows(), effect.start, {}
    for name, row in rows.items():
        # at its start an effect adds nothing; otherwise the test below fails
        there = effect.at(columns, {**start, name: start[name] + row.little})
        units[name] = Terms().plus(there, 1.0 / row.little)
    known = LinearisedEffect(effect, units)
    # an arbitrary point inside the bounds
    inside = {
        name: row.lower + 0.37 * (row.upper - row.lower) for name, row in rows.items()
    }
    longest = max((unit.rows for unit in units.values()), default=0)
    some = slice(None, None, max(1, longest // SOME))
    by_slopes = known.on_rows(some).at(columns, inside)
    if some.step > 1:
        # a few rows suffice, unless the terms of a row depend on other rows
        thin = {name: columns[name][some] for name in effect.drivers}
        with suppress(Exception):
            if effect.at(thin, inside).is_near(by_slopes):
                return known
    return known if effect.at(columns, inside).part(some).is_near(by_slopes) else effect


def deciding_measurements(effects: list) -> list:
    """
    Measurements that would distinguish some effects from their alternatives.

    Parameters
    ----------
    effects : list of Effect

    Returns
    -------
    list of str
        Phrases, each once; a driver of its own if no effect has one.
    """
    words = dict.fromkeys(e.decided_by for e in effects if e.decided_by)
    return list(words) or ["a driver of its own"]
