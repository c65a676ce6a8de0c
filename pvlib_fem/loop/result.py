"""The result of a closed loop: finished, and it prints itself."""

import json
from dataclasses import asdict, dataclass, field

import pandas as pd

from pvlib_fem import plotting
from pvlib_fem.drivers import geometry
from pvlib_fem.findings import Kind
from pvlib_fem.fitting.result import FemFit, without_nan
from pvlib_fem.loop.criteria import Criteria
from pvlib_fem.record.columns import COLUMNS, GEOMETRY, with_aliases
from pvlib_fem.report.document import saved
from pvlib_fem.report.page import page
from pvlib_fem.report.text import NEVER, lines


@dataclass(frozen=True, eq=False)
class Loop:
    """
    The closed loop: what a record shows beyond the model, and what that is worth.

    ``print(loop)`` is the report.

    Attributes
    ----------
    findings : tuple of Finding
        In the order found, then hints, then what no effect explains.
    corrections : tuple of Correction
        What was made of clocks that are off.
    table : DataFrame
        A row for each step, ``steady``, ``fem`` (the paper's form), ``balance``,
        ``clock corrected`` where it was, then ``+<effect>``; errors on fitting and
        test weeks [K], on test days and nights alone, and the error of the test
        weeks' performance ratio that they cause [percentage points].
    base, last : str
        Rows of the table: the better of ``fem`` and ``balance``, and the last step.
    untestable : dict of Because
        Effect to what it would need, or why this record cannot see it.
    ranking : DataFrame
        What each absent effect would still explain, given the model that is
        returned, see :func:`pvlib_fem.rank_effects`.
    fit : FemFit
        Of the last step, to the fitting weeks.
    notes : tuple of str
        The state of the record, and what was done about it.
    place : dict
        ``location``, ``surface_tilt`` and ``surface_azimuth`` as given.
    residual_before : Series
        Measured minus modelled temperature before anything was added. [K]
    weeks : Series of category
        What each row was for: ``fitting``, ``choosing`` or ``test``.
    plain : tuple of ThermalModel and dict
        The model without effects, and its coefficients.
    criteria : Criteria
        By which it decided.
    family : int
        Hypotheses among which each chance is counted.
    weighed : bool
        Whether there were enough fitting days to leave some out in turn.
    given : dict
        Other arguments of the call, as given.
    """

    findings: tuple
    corrections: tuple
    table: pd.DataFrame
    base: str
    last: str
    untestable: dict
    ranking: pd.DataFrame = field(repr=False)
    fit: FemFit = field(repr=False)
    notes: tuple
    place: dict
    residual_before: pd.Series = field(repr=False)
    weeks: pd.Series = field(repr=False)
    plain: tuple = field(repr=False)
    criteria: Criteria = field(repr=False)
    family: int = 1
    weighed: bool = True
    given: dict = field(repr=False, default_factory=dict)

    @property
    def effects(self):
        """Names of the findings that were added to the model, in order."""
        return [finding.effect for finding in self.findings if finding.added]

    @property
    def ties(self):
        """Name to the other candidates, where there are some."""
        return {
            f.effect: tuple(n for n in f.candidates if n != f.effect)
            for f in self.findings
            if f.kind is not Kind.STRUCTURE and len(f.candidates) > 1
        }

    @property
    def unexplained(self):
        """Findings of structure that no effect explains."""
        return tuple(f for f in self.findings if f.kind is Kind.STRUCTURE)

    def inputs(self, data):
        """The usual three columns of ``data``, and those that the effects need."""
        columns = with_aliases(data, COLUMNS[:3])
        wanted = self.fit.thermal_model.drivers
        if {*wanted} & {*GEOMETRY} - {*columns}:
            columns = {**geometry(data.index, **self.place), **columns}
        drivers = {name: columns[name] for name in wanted if name in columns}
        return [columns[name] for name in COLUMNS[:3]], drivers

    def predict(self, data, fallback=False):
        """
        Module temperature of the last step.

        Parameters
        ----------
        data : DataFrame
            ``poa_global``, ``temp_air``, ``wind_speed`` and the columns of the
            effects.
        fallback : bool, default False
            Where the column of an effect lacks, take the model without any effect
            instead of NaN.

        Returns
        -------
        Series
            [°C]; NaN where one of those lacks.

        Raises
        ------
        ValueError
            If a whole column lacks, and there is no fallback.
        """
        usual, drivers = self.inputs(data)
        model, coefficients = self.plain
        if not fallback:
            return self.fit.predict(*usual, **drivers)
        plain = model.predict(*usual, coefficients)
        if {*self.fit.thermal_model.drivers} - {*drivers}:
            return plain
        return self.fit.predict(*usual, **drivers).fillna(plain)

    def contributions(self, data):
        """
        What each effect adds to the temperature, with all the others there.

        Parameters
        ----------
        data : DataFrame
            As in :meth:`predict`.

        Returns
        -------
        DataFrame
            A column for each effect. [K]
        """
        usual, drivers = self.inputs(data)
        fit, model = self.fit, self.fit.thermal_model
        whole = model.predict(*usual, fit.coefficients, **drivers)
        parts = {}
        for effect in fit.effects:
            nothing = {name: row.start for name, row in effect.rows().items()}
            without = {**fit.coefficients, **nothing}
            parts[effect.name] = whole - model.predict(*usual, without, **drivers)
        return pd.DataFrame(parts, index=data.index)

    def temperature_model(self, **options):
        """
        The last step as a temperature model for pvlib's ModelChain.

        Parameters
        ----------
        **options
            ``deltaT`` or ``k_bs_c``, see :class:`DynamicCellTemperature`, and the
            drivers of the effects at the times of the run; by default those of
            this record. The sun's place comes from the chain.

        Returns
        -------
        DynamicCellTemperature
        """
        record = self.fit.record
        own = {
            name: pd.Series(record[name], record.index)
            for name in self.fit.thermal_model.drivers
            if name not in GEOMETRY
        }
        return self.fit.temperature_model(**{**own, **options})

    def plot(self, ax=None):
        """
        Measured temperature on the most variable test day, modelled before and after.

        Parameters
        ----------
        ax : matplotlib Axes, optional

        Returns
        -------
        matplotlib Axes
        """
        return plotting.plot_before_after(self, ax)

    def to_html(self, path=None):
        """
        The report with pictures as one HTML file, which needs nothing beside it.

        Parameters
        ----------
        path : str or path-like, optional
            File to write.

        Returns
        -------
        str
        """
        return saved(page(self, NEVER), path)

    def to_json(self, path=None):
        """
        The loop as JSON: findings, table, what was not testable, and the fit.

        Parameters
        ----------
        path : str or path-like, optional
            File to write.

        Returns
        -------
        str
        """
        content = {
            "findings": [finding.content() for finding in self.findings],
            "corrections": [one.content() for one in self.corrections],
            "table": self.table.to_dict(orient="index"),
            "base": self.base,
            "last": self.last,
            "untestable": {n: why.content() for n, why in self.untestable.items()},
            "notes": list(self.notes),
            "weeks": self.weeks.value_counts().to_dict(),
            "criteria": asdict(self.criteria),
            "family": self.family,
            "fit": json.loads(self.fit.to_json()),
        }
        text = json.dumps(without_nan(content), indent=2, ensure_ascii=False)
        if path is not None:
            saved(text + "\n", path)
        return text

    def __str__(self):
        return "\n".join(lines(self))
