"""The result of a closed loop: finished, and it prints itself."""

import json
from dataclasses import asdict, dataclass, field

import pandas as pd

from pvlib_fem import plotting
from pvlib_fem.drivers import geometry
from pvlib_fem.findings import ADDED
from pvlib_fem.fitting.result import FemFit, without_nan
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
        In the order found.
    table : DataFrame
        A row for each step, ``steady``, ``fem`` (the paper's form), ``balance``,
        then ``+<effect>``; errors on the fitted and the sealed days [K], on sealed
        days and nights alone, and the error of the sealed days' performance ratio
        that they cause [percentage points].
    untestable : dict
        Effect to what it would need, or why this record cannot see it.
    ranking : DataFrame
        What each absent effect would still explain, see
        :func:`pvlib_fem.rank_effects`.
    fit : FemFit
        Of the last step.
    notes : tuple of str
        The state of the record, and what was done about it.
    place : dict
        ``location``, ``surface_tilt`` and ``surface_azimuth`` as given.
    residual_before : Series
        Measured minus modelled temperature before any effect. [K]
    min_gain : float
        As given. [K]
    weighed : bool
        Whether there were enough open days to leave some out in turn.
    """

    findings: tuple
    table: pd.DataFrame
    untestable: dict
    ranking: pd.DataFrame = field(repr=False)
    fit: FemFit = field(repr=False)
    notes: tuple
    place: dict
    residual_before: pd.Series = field(repr=False)
    min_gain: float = 0.15
    weighed: bool = True

    @property
    def base(self):
        """Row of the table that it went on from: ``fem`` or ``balance``."""
        return {"ewm": "fem"}.get(self.fit.dynamics, self.fit.dynamics)

    @property
    def last(self):
        """Row of the table of the last step; the base where nothing was added."""
        row = self.table.index[-1]
        return row if row.startswith("+") else self.base

    @property
    def effects(self):
        """Names of the findings that were added to the model, in order."""
        return [f.effect for f in self.findings if f.verdict in ADDED]

    @property
    def ties(self):
        """Name to the other candidates, where there are some."""
        return {
            f.effect: tuple(n for n in f.candidates if n != f.effect)
            for f in self.findings
            if f.verdict != "unknown" and len(f.candidates) > 1
        }

    @property
    def unexplained(self):
        """Findings of structure that no effect explains."""
        return tuple(f for f in self.findings if f.verdict == "unknown")

    def inputs(self, data):
        """The usual three columns of ``data``, and those that the effects need."""
        columns = with_aliases(data, COLUMNS[:3])
        wanted = self.fit.thermal_model.drivers
        if {*wanted} & {*GEOMETRY} - {*columns}:
            columns = {**geometry(data.index, **self.place), **columns}
        drivers = {name: columns[name] for name in wanted if name in columns}
        return [columns[name] for name in COLUMNS[:3]], drivers

    def predict(self, data):
        """
        Module temperature of the last step.

        Parameters
        ----------
        data : DataFrame
            ``poa_global``, ``temp_air``, ``wind_speed`` and the columns of the
            effects.

        Returns
        -------
        Series
            [°C]

        Raises
        ------
        ValueError
            If a column lacks.
        """
        usual, drivers = self.inputs(data)
        return self.fit.predict(*usual, **drivers)

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
        Measured temperature on the most variable sealed day, modelled before and after.

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
            "findings": [asdict(finding) for finding in self.findings],
            "table": self.table.to_dict(orient="index"),
            "untestable": self.untestable,
            "notes": list(self.notes),
            "fit": json.loads(self.fit.to_json()),
        }
        text = json.dumps(without_nan(content), indent=2, ensure_ascii=False)
        if path is not None:
            saved(text + "\n", path)
        return text

    def __str__(self):
        return "\n".join(lines(self))
