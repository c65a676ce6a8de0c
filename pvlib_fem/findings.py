"""What a closed loop found: finished, and it prints itself."""

import json
from dataclasses import asdict, dataclass, field

import numpy as np
import pandas as pd

from pvlib_fem import plotting, report
from pvlib_fem.diagnosis import with_aliases
from pvlib_fem.document import rounded, saved
from pvlib_fem.drivers import GEOMETRY, geometry
from pvlib_fem.paper import COLUMNS
from pvlib_fem.plotting.steps import BASES
from pvlib_fem.report import ADDED, by_reason
from pvlib_fem.result import FemFit, without_nan

NEVER = (
    "absorptance, irradiance gain, mean rear irradiance: all are k",
    "sensor height, mean shelter: both are the wind's coefficient",
    "offsets of either thermometer, mean sky: all are the bias",
    "drifts of sensor gain, absorptance, contact at the back: sensitivity_drift by day",
)


@dataclass(frozen=True)
class Finding:
    """
    One thing that the record shows.

    Attributes
    ----------
    effect : str
        Name of the effect, or the drivers along which unknown structure lives.
    candidates : tuple of str
        All names that the data cannot tell from it, itself included.
    verdict : str
        ``"named"``; ``"class"``, one of the candidates; ``"suggestive"``, not
        added to the model; ``"unknown"``, which no effect explains.
    gain : float
        What it takes off the held-out error: root of the fall of its mean square,
        over weeks of the open part left out in turn. [K]
    coefficients, stderr : dict
        Those of the last fit where it was added, else of the ranking.
    why : str
        The reason for the verdict, in one line.
    where : dict
        Of unknown structure: from and to of each driver.
    """

    effect: str
    candidates: tuple
    verdict: str
    gain: float
    coefficients: dict
    stderr: dict
    why: str
    where: dict = field(default_factory=dict)


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
        return saved(report.page(self, NEVER), path)

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


WIDE = 24  # characters of the first column of the report
#: what the numbers of a clock are: unit, and words for either sign
LATE = {
    "minutes": ("min", "late", "early"),
    "drift": ("s", "later each day", "earlier each day"),
    "summer": ("min", "late in summer", "early in summer"),
}


def lines(loop):
    """Lines of the printed report."""
    fit = loop.fit
    record = fit.record
    seconds = np.diff(record.inputs.seconds)
    step = float(np.median(seconds)) if len(seconds) else np.nan
    width = f"{step / 60:g} min" if step >= 60 else f"{step:g} s"
    days = len(np.unique(record.dates))
    yield (
        f"pvlib_fem: the loop on {days} day{'s' if days > 1 else ''} at {width} · "
        f"{len(record.index):,} rows "
        f"· {fit.test_days} days sealed · {fit.model}, {fit.dynamics}"
    )
    head = ("RMSE", "day", "night", "MBE")
    part = "test" if fit.test_days else "train"
    shown = (f"rmse_{part}", "rmse_test_day", "rmse_test_night", f"mbe_{part}")
    cells = "".join(f"{name:>7}" for name in head)
    yield f"{'step':<{WIDE}}{cells}  energy error  verdict"
    verdicts = {f"+{f.effect}": f for f in loop.findings if f.verdict in ADDED}
    for name, row in loop.table.iterrows():
        cells = "".join(cell(row[key], 7) for key in shown)
        cells += cell(row["energy_error_test"], 9) + " %"
        title = BASES.get(name, name.replace("+", "+ ", 1))
        words = verdict(verdicts[name], loop) if name in verdicts else ""
        yield f"{title:<{WIDE}}{cells}    {words}".rstrip()
    for finding in loop.unexplained:
        yield f"{'left':<{WIDE}}{finding.why}"
    for finding in loop.findings:
        title = {"class": "cannot tell", "suggestive": "suggestive"}
        if finding.verdict in title:
            names = " | ".join(finding.candidates)
            if finding.candidates == (finding.effect,) and finding.verdict == "class":
                names += " or its like"  # of which the catalogue has none
            words = f"{names} ({finding.gain:.2f} K): {finding.why}"
            yield f"{title[finding.verdict]:<{WIDE}}{words}"
    for why, names in by_reason(loop.untestable).items():
        yield f"{'not testable':<{WIDE}}{', '.join(names)} ({why})"
    for i, words in enumerate(NEVER):
        yield f"{'' if i else 'never from these columns':<{WIDE}}  {words}"
    if not fit.test_days:
        yield f"{'note':<{WIDE}}nothing is sealed: these are errors of the fitted days"
    yield from (f"{'note':<{WIDE}}{note}" for note in loop.notes)


def cell(value, width):
    return f"{'–':>{width}}" if np.isnan(value) else f"{value:>{width}.2f}"


def verdict(finding, loop):
    """Words behind the row of an added effect."""
    found = [e for e in loop.fit.effects if e.name == finding.effect]
    if not found:  # a clock, which is corrected and not modelled
        parts = []
        for key, value in finding.coefficients.items():
            around = (
                f" ± {rounded(finding.stderr[key])}" if key in finding.stderr else ""
            )
            unit, late, early = LATE[key.split(".")[-1]]
            way = late if value > 0 else early
            parts.append(f"{abs(value):.1f}{around} {unit} {way}")
        return f"{finding.verdict}  {', '.join(parts)}"
    (effect,) = found
    parts = []
    for key, row in effect.rows().items():
        value, error = finding.coefficients[key], finding.stderr[key]
        digits = max(0, 1 - int(np.floor(np.log10(error)))) if error > 0 else 3
        name = f"{key.split('.')[-1]} " if len(effect.parameters) > 1 else ""
        unit = "" if row.unit == "-" else f" {row.unit}"
        parts.append(f"{name}{value:.{min(digits, 6)}f} ± {error:.2g}{unit}")
    words = f"{finding.verdict}  {', '.join(parts)}"
    # of a column of the user's own it says nothing but the column's unit
    if len(effect.parameters) == 1 and not effect.name.startswith("driver:"):
        (row,) = effect.parameters.values()
        words += f" ({row.lower:.3g} … {row.upper:.3g})"
    return words + (f", from {effect.source}" if effect.source else "")
