"""The result of a fit: finished, and it prints itself."""

import json
from dataclasses import dataclass, field

import numpy as np
import pandas as pd
from scipy.stats import t as student

from pvlib_fem import plotting
from pvlib_fem.modelchain import DynamicCellTemperature
from pvlib_fem.record.checks import Record, instants
from pvlib_fem.report.document import rounded, saved
from pvlib_fem.thermal.model import thermal_model


@dataclass(frozen=True, eq=False)
class FemFit:
    """
    Fitted coefficients of a module, and what they are worth.

    ``print(fit)`` is the report. ``coefficients`` unpack into
    :func:`pvlib_fem.fem_temperature` (``ewm``, and ``steady``, whose ``tau`` is
    an instant) or :func:`pvlib_fem.heat_balance` (``balance``).

    Attributes
    ----------
    model, dynamics, method : str
        As given to :func:`fit_fem`.
    effects : tuple of Effect
        Physical effects that were fitted beside the model.
    coefficients : dict
        Those of the model, ``tau`` [s] or ``capacity`` [J/(m² K)], and ``bias``
        [K].
    stderr : dict
        Their standard errors from the spread between training days; NaN where
        there is none, see ``notes``.
    scores : DataFrame
        What each step bought, in K on daytime rows: ``standard`` (steady,
        fitted to all rows), ``filter`` (steady, fitted to the filtered rows),
        ``ewm`` (with the dynamics) and ``fem`` (with the bias), then a row for
        each effect; the last row is this fit.
    residual : Series
        Measured minus modelled temperature on all rows. [K]
    at_bound : tuple of str
        Coefficients that ended at a bound of their range.
    converged : bool
        Whether the search ended at a minimum.
    notes : tuple of str
        What the reader of the numbers has to know.
    train_days, test_days : int
        Days with daytime rows in either part.
    holdout : Series
        Boolean, the rows held out.
    record : Record
        The record as it was checked.
    night : bool
        Whether night rows count, too.
    base : dict or None
        Coefficients of the step before the effects, by which effects know the
        temperature of the module; None without effects.
    fixed : dict
        Coefficients that were held and not fitted; their error is 0.
    """

    model: str
    dynamics: str
    method: str
    effects: tuple
    coefficients: dict
    stderr: dict
    scores: pd.DataFrame
    residual: pd.Series = field(repr=False)
    at_bound: tuple
    converged: bool
    notes: tuple
    train_days: int
    test_days: int
    holdout: pd.Series = field(repr=False)
    record: Record = field(repr=False)
    night: bool = False
    base: dict | None = None
    fixed: dict = field(default_factory=dict)

    @property
    def thermal_model(self):
        """The steady model, dynamics and effects that were fitted."""
        return thermal_model(
            self.model, self.dynamics, self.effects, self.base, self.fixed
        )

    def predict(self, poa_global, temp_air, wind_speed, **drivers):
        """
        Module temperature with these coefficients.

        Parameters
        ----------
        poa_global, temp_air, wind_speed : Series
            [W/m²], [°C], [m/s]
        **drivers : Series
            Those of the effects.

        Returns
        -------
        Series
            [°C]
        """
        return self.thermal_model.predict(
            poa_global, temp_air, wind_speed, self.coefficients, **drivers
        )

    def confidence_interval(self, level=0.95):
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
        factor = student.ppf(0.5 + level / 2, max(self.train_days - 1, 1))
        value, error = pd.Series(self.coefficients), pd.Series(self.stderr)
        return pd.DataFrame(
            {"lower": value - factor * error, "upper": value + factor * error}
        )

    def temperature_model(self, **options):
        """
        These coefficients as a temperature model for pvlib's ModelChain.

        Parameters
        ----------
        **options
            ``deltaT`` or ``k_bs_c`` from the back of the module to its cells,
            and drivers by name, see :class:`DynamicCellTemperature`.

        Returns
        -------
        DynamicCellTemperature
        """
        return DynamicCellTemperature(
            self.model,
            self.dynamics,
            self.coefficients,
            effects=self.effects,
            base=self.base,
            **options,
        )

    def plot(self, ax=None, when=None):
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
        return plotting.plot_fit(self, ax, when)

    def to_json(self, path=None):
        """
        The fit as JSON, of which ``DynamicCellTemperature.from_json`` makes a model.

        Parameters
        ----------
        path : str or path-like, optional
            File to write.

        Returns
        -------
        str
        """
        content = {
            "model": self.model,
            "dynamics": self.dynamics,
            "method": self.method,
            "effects": [effect.spec for effect in self.effects],
            "coefficients": self.coefficients,
            "stderr": self.stderr,
            "fixed": self.fixed,
            "base": self.base,
            "scores": self.scores.to_dict(orient="index"),
            "at_bound": list(self.at_bound),
            "converged": self.converged,
            "notes": list(self.notes),
            "train_days": self.train_days,
            "test_days": self.test_days,
            "record": {
                "rows": len(self.record.index),
                "from": str(self.record.index[0]),
                "to": str(self.record.index[-1]),
                "missing": self.record.missing,
                "impossible": self.record.impossible,
                "clipped": self.record.clipped,
            },
        }
        text = json.dumps(without_nan(content), indent=2, ensure_ascii=False)
        saved(text + "\n", path)
        return text

    def __str__(self):
        return "\n".join(report(self))


def without_nan(content):
    """JSON has no NaN: null stands for it."""
    if isinstance(content, dict):
        return {key: without_nan(value) for key, value in content.items()}
    if isinstance(content, list | tuple):
        return [without_nan(value) for value in content]
    if isinstance(content, float) and not np.isfinite(content):
        return None
    return content


def report(fit):
    """Lines of the printed report."""
    record = fit.record
    index = record.index
    step = float(np.median(np.diff(instants(index)) / np.timedelta64(1, "s")))
    added = "".join(f" + {effect.name}" for effect in fit.effects)
    yield f"pvlib_fem: {fit.model}{added}, {fit.dynamics}, {fit.method}"
    yield (
        f"{len(index):,} rows, {index[0]:%Y-%m-%d} to {index[-1]:%Y-%m-%d}, "
        f"step {step:g} s; {fit.train_days} days fitted, {fit.test_days} held out"
    )
    yield ""
    rows = fit.thermal_model.parameters
    wide = max(12, *(len(name) + 1 for name in (*rows, *fit.scores.index)))
    yield f"{'coefficient':<{wide}}{'value':>12}{'± error':>12}   unit"
    for name, row in rows.items():
        value, error = fit.coefficients[name], fit.stderr[name]
        bound = "   at its bound" if name in fit.at_bound else ""
        error = "held" if name in fit.fixed else rounded(error)
        yield f"{name:<{wide}}{value:>12.5g}{error:>12}   {row.unit}{bound}"
    yield ""
    yield f"what each step bought, {'day and night' if fit.night else 'daytime'} [K]"
    wide = wide if fit.effects else 10
    yield f"{'':<{wide}}{'fitted days':^24}  {'held-out days':^24}".rstrip()
    yield f"{'step':<{wide}}" + "  ".join(
        "".join(f"{score:>8}" for score in ("RMSE", "MAE", "MBE")) for _ in range(2)
    )
    for name, line in fit.scores.iterrows():
        cells = [f"{value:>z8.2f}" for value in line]
        yield f"{name:<{wide}}{''.join(cells[:3])}  {''.join(cells[3:])}"
    yield ""
    for what, counts in (
        ("missing", record.missing),
        ("impossible, not used", record.impossible),
    ):
        if counted := [f"{name} {count:,}" for name, count in counts.items() if count]:
            yield f"{what}: {', '.join(counted)}"
    if record.clipped:
        yield f"negative irradiance, clipped to 0: {record.clipped:,}"
    if not np.isnan(list(fit.stderr.values())).all():
        yield f"errors: clustered by day, from the spread of {fit.train_days} days"
    yield from (f"note: {note}" for note in fit.notes)
