"""Parameters of other models from the coefficients of a fit alone."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from pvlib_fem._thermal_parameters.given_record import Measured
from pvlib_fem._thermal_parameters.parameter_rows import Row
from pvlib_fem._translation import SHAPES, at_winds, reciprocal

NOMINAL = 800.0  # W/m², of NOCT and NMOT; the bias is added at this irradiance
AIR = 20.0  # °C, of NOCT and NMOT
BREEZE = 1.0  # m/s, of NOCT and NMOT
HEIGHT = 10.0  # m, of the wind in weather files
TAU_WINDS = (1.0, 3.0, 5.0)  # m/s
SUNS = np.array([400.0, 1000.0])  # W/m², range in which models are compared
NUDGE = 1e-2  # step of finite differences, in standard errors

FAIMAN = "D. Faiman, Prog. Photovolt. 16, 307 (2008), doi:10.1002/pip.813; IEC 61853-2"
KING = "D. L. King et al., SAND2004-3535 (2004), doi:10.2172/919131"
ROSS = "R. G. Ross, 14th IEEE PVSC (1980), as pvlib.temperature.ross"
SAM = "P. Gilman et al., NREL/TP-6A20-67399 (2018), as pvlib.temperature.noct_sam"
PVSYST = "PVsyst help, Array thermal losses, as pvlib.temperature.pvsyst_cell"
IEC = "IEC 61853-2:2016 and IEC 61215-2:2016, MQT 05"
HERTELEER = "B. Herteleer et al. (2022), doi:10.22541/au.166922866.68736478"

POSSIBLE = (
    "no such model: the over-temperature grows with wind, or is negative with the "
    "bias; try with_bias=False"
)
ROUGH = "shorter than the record's step, so only rough; use a finer record"
NO_EFFECTS = "without {}; give data to add their mean on the record"
NO_LOSS = "without the losses of effects"
NO_ERROR = "no error: the fit has none, see its notes"
NO_DELTA = (
    "a sensor on the back does not measure the cells; give deltaT (pvlib has 3 K for "
    "open racks, 1 K close to a roof, 0 K on insulation)"
)
NO_WINDS = (
    "needs the record: a model without wind depends on the winds of the site; give data"
)
NO_HEIGHT = "needs the height of the anemometer, wind_height"
GIVEN = "given or assumed, not measured"
OF_SENSOR = "cells taken as warm as the sensor, since deltaT is unknown"


@dataclass(frozen=True)
class Curve:
    """Resistance as a function of wind, with the interface of a model's shape."""

    curve: Callable

    def resistance(
        self, wind_speed: Sequence | float | np.ndarray, own: dict | None = None
    ) -> Any:
        return self.curve(np.asarray(wind_speed, float))

    def seen_at(self, share: float | None) -> "Curve":
        """The curve as a function of another wind, with a given ratio to it."""
        return Curve(lambda wind_speed: self.curve(wind_speed * share))

    def plus(self, more: float) -> "Curve":
        """The curve plus a constant. [K m²/W]"""
        return Curve(lambda wind_speed: self.curve(wind_speed) + more)


@dataclass(frozen=True)
class Convention:
    """A model of other tools, in which the resistance is expressed."""

    name: str
    shape: str
    of: str
    units: Mapping
    equation: str
    source: str
    fixed: Mapping = field(default_factory=dict)
    high: bool = False  # whether its wind is at 10 m
    calm: bool = False  # whether it has one parameter and no wind


def conventions(module_efficiency: float, absorptance: float) -> list:
    """
    All conventions of the table, in order.

    Parameters
    ----------
    module_efficiency, absorptance : float
        Of the module. [-]

    Returns
    -------
    list of Convention
    """
    faiman = {"u0": "W/(m² K)", "u1": "W s/(m³ K)"}
    sandia = {"a": "ln(K m²/W)", "b": "s/m"}
    pvsyst = {"u_c": "W/(m² K)", "u_v": "W s/(m³ K)"}
    absorbed = dict(module_efficiency=module_efficiency, alpha_absorption=absorptance)
    seen = dict(
        module_efficiency=module_efficiency, transmittance_absorptance=absorptance
    )
    ross, t_ross = {"k": "K m²/W"}, "T = T_air + k G"
    t_faiman = "T = T_air + G / (u0 + u1 WS)"
    t_sandia = "T = T_air + G exp(a + b WS); cell: + deltaT G / 1000"
    t_pvsyst = "T = T_air + alpha_absorption (1 - module_efficiency) G / (u_c + u_v WS)"
    t_sam = (
        "T = T_air + G / 800 (noct - 20) "
        "(1 - module_efficiency / transmittance_absorptance) 9.5 / (5.7 + 3.8·0.51 WS)"
    )
    ten: dict[str, Any] = dict(high=True)
    sam = {"noct": "°C"}
    return [
        Convention("faiman", "faiman", "module", faiman, t_faiman, FAIMAN),
        Convention("sapm", "sapm", "module", sandia, t_sandia, KING),
        Convention("sapm, 10 m", "sapm", "module", sandia, t_sandia, KING, **ten),
        Convention("ross", "ross", "module", ross, t_ross, ROSS, calm=True),
        Convention("noct_sam", "noct_sam", "cell", sam, t_sam, SAM, seen),
        Convention("noct_sam, 10 m", "noct_sam", "cell", sam, t_sam, SAM, seen, **ten),
        Convention("pvsyst", "pvsyst", "cell", pvsyst, t_pvsyst, PVSYST, absorbed),
        Convention(
            "pvsyst, 10 m", "pvsyst", "cell", pvsyst, t_pvsyst, PVSYST, absorbed, **ten
        ),
        Convention(
            "pvsyst, no wind",
            "pvsyst",
            "cell",
            pvsyst,
            t_pvsyst,
            PVSYST,
            absorbed,
            calm=True,
        ),
    ]


@dataclass(frozen=True)
class Steady:
    """
    A fit as over-temperature per irradiance of module and cells.

    Attributes
    ----------
    fit : FemFit
    deltaT : float or None
        Cell minus back temperature at 1000 W/m². [K]
    with_bias : bool
        Whether the fit's bias belongs to the module's temperature.
    share : float or None
        Wind at the anemometer over wind at 10 m.
    winds : array
        Winds at which models are fitted, with equal weights. [m/s]
    measured : Measured or None
    """

    fit: Any
    deltaT: float | None
    with_bias: bool
    share: float | None
    winds: np.ndarray
    measured: Measured | None = None

    def resistance_line(self, coefficients: dict) -> Curve:
        """The resistance of the steady model as a function of wind."""
        model = self.fit.thermal_model
        law, completed = model.steady_model, model.completed(coefficients)
        own = model.steady_coefficients(completed)
        return Curve(lambda wind_speed: law.resistance(wind_speed, **own))

    def curve(self, coefficients: dict, of: str) -> Curve:
        """Over-temperature per irradiance at 800 W/m², with bias and cell."""
        more = self.bias(coefficients) / NOMINAL
        return self.resistance_line(coefficients).plus(more + self.cell(of) / 1000.0)

    def bias(self, coefficients: dict) -> float:
        """Bias and mean effects, added to the over-temperature at 800 W/m². [K]"""
        added = coefficients["bias"] if self.with_bias else 0.0
        return added + self.effects(coefficients)

    def effects(self, coefficients: dict) -> Any:
        return 0.0 if self.measured is None else self.measured.effects(coefficients)

    @property
    def effects_note(self) -> str:
        """A note on effects that are not included without the record."""
        names = ", ".join(effect.name for effect in self.fit.effects)
        return NO_EFFECTS.format(names) if names and self.measured is None else ""

    def cell(self, of: str) -> float:
        return self.deltaT or 0.0 if of == "cell" else 0.0

    def at_height(self, one: Convention, curve: Curve) -> tuple[Curve, np.ndarray]:
        """A curve and the winds, at the height of a convention."""
        if one.high:
            return curve.seen_at(self.share), self.winds / self.share
        return curve, self.winds

    def line(self, one: Convention, coefficients: dict) -> tuple[float, float] | None:
        """The convention's line in wind by least squares; None if impossible."""
        curve, winds = self.at_height(one, self.curve(coefficients, one.of))
        goal = SHAPES[one.shape]
        resistance = curve.resistance(winds)
        if not (resistance > 0.0).all():
            return None
        if one.calm:
            return goal.bend(resistance.mean()), 0.0
        first, second = (float(v) for v in at_winds(curve, {}, goal, winds))
        warms = second < 0.0 if goal.bend is reciprocal else second > 0.0
        return None if warms else (first, second)

    def parameters(self, one: Convention, coefficients: dict) -> dict:
        """The convention's parameters by name; NaN if impossible."""
        line = self.line(one, coefficients)
        if line is None:
            return dict.fromkeys(one.units, np.nan)
        return SHAPES[one.shape].coefficients(*line, **one.fixed)

    def mismatch(self, one: Convention, values: dict) -> float:
        """Largest difference from the fit at 400 to 1000 W/m² and all winds. [K]"""
        coefficients = self.fit.coefficients
        curve = self.resistance_line(coefficients).plus(self.cell(one.of) / 1000.0)
        curve, winds = self.at_height(one, curve)
        own = SHAPES[one.shape].resistance(winds, {**values, **one.fixed})
        over = np.outer(SUNS, curve.resistance(winds)) + self.bias(coefficients)
        return float(np.abs(np.outer(SUNS, own) - over).max())

    def error(self, function: Any) -> Any:
        """Standard errors of some numbers by the delta method, as an array."""
        covariance = self.fit.covariance
        if covariance.empty:
            return np.full(len(function(self.fit.coefficients)), np.nan)
        slopes = []
        for name in covariance:
            step = NUDGE * np.sqrt(covariance.loc[name, name])
            there = [
                function(
                    {**self.fit.coefficients, name: self.fit.coefficients[name] + s}
                )
                for s in (step, -step)
            ]
            slopes.append((there[0] - there[1]) / (2.0 * step))
        slopes = np.array(slopes)
        variance = np.einsum("ik,ij,jk->k", slopes, covariance.to_numpy(), slopes)
        return np.sqrt(np.maximum(variance, 0.0))


def steady_rows(steady: Any, chosen: list) -> Iterator:
    """
    Rows of other models' parameters.

    Parameters
    ----------
    steady : Steady
    chosen : sequence of Convention

    Yields
    ------
    Row
    """
    for one in chosen:
        why = NO_HEIGHT if one.high and steady.share is None else ""
        why = NO_WINDS if one.calm and steady.measured is None else why
        there, values = not why, dict.fromkeys(one.units, np.nan)
        errors, mismatch = [np.nan] * len(values), np.nan
        if there:
            values = steady.parameters(one, steady.fit.coefficients)
        if there and np.isfinite(list(values.values())).all():
            errors = steady.error(
                lambda c, one=one: np.array([*steady.parameters(one, c).values()])
            )
            mismatch = steady.mismatch(one, values)
            warm = OF_SENSOR if one.of == "cell" and steady.deltaT is None else ""
            why = joined_notes(warm, steady.effects_note)
        elif there:
            why = POSSIBLE
        like = dict(of=one.of, equation=one.equation, source=one.source)
        for (name, value), error in zip(values.items(), errors):
            yield parameter_row(
                steady,
                one.name,
                name,
                value,
                one.units[name],
                error,
                mismatch,
                why,
                like,
            )
        for name, value in one.fixed.items():
            yield Row(one.name, name, value, "-", note=GIVEN, **like)
        if one.shape == "sapm":
            yield of_cell(steady, one.name, like)


def joined_notes(*notes: str) -> str:
    """
    Notes in one line, without those that are empty.

    Parameters
    ----------
    *notes : str

    Returns
    -------
    str
    """
    return "; ".join(filter(None, notes))


def parameter_row(
    steady: Any,
    convention: str,
    name: str,
    value: float,
    unit: str,
    error: float,
    mismatch: float,
    why: str,
    like: dict,
) -> Row:
    """A row of a parameter whose error is from the fit."""
    freedom = steady.fit.train_days - 1.0
    if np.isfinite(value) and not np.isfinite(error):
        why = joined_notes(why, NO_ERROR)
    return Row(
        convention,
        name,
        float(value),
        unit,
        float(error),
        freedom,
        mismatch=mismatch,
        note=why,
        **like,
    )


def of_cell(steady: Steady, convention: str, like: dict) -> Row:
    """The row of deltaT, cell minus back temperature."""
    value = np.nan if steady.deltaT is None else steady.deltaT
    note = NO_DELTA if steady.deltaT is None else GIVEN
    return Row(convention, "deltaT", value, "K", note=note, **{**like, "of": "cell"})


def nmot_row(steady: Any) -> Row:
    """
    The row of the fit's temperature at 800 W/m², 20 °C of air and 1 m/s.

    Parameters
    ----------
    steady : Steady

    Returns
    -------
    Row
        NMOT of the fit. [°C]
    """

    def nmot(coefficients: dict) -> float | np.ndarray:
        curve = steady.curve(coefficients, "module")
        return AIR + NOMINAL * curve.resistance([BREEZE])

    (value,), (error,) = nmot(steady.fit.coefficients), steady.error(nmot)
    like = dict(
        of="module",
        equation="NMOT = 20 °C + 800 W/m² r_eq(1 m/s) + bias",
        source=IEC,
    )
    why = steady.effects_note
    return parameter_row(
        steady, "nmot", "of the fit", value, "°C", error, np.nan, why, like
    )


def memory_rows(steady: Any) -> Iterator:
    """
    Rows of time constants by wind, for samples at the end of steps and for means.

    Parameters
    ----------
    steady : Steady

    Yields
    ------
    Row
        Time constant at 1, 3 and 5 m/s, for each kind of sample. [s]
    """
    fit, why = steady.fit, ""
    if fit.dynamics == "steady":
        why = "dynamics='steady' has no memory; fit with 'balance' or 'ewm'"
    if fit.dynamics == "ewm":
        why = "one tau at all winds; with dynamics='balance' it follows the wind"
    elif fit.effects:
        why = NO_LOSS

    def taus(coefficients: dict) -> np.ndarray:
        if fit.dynamics == "ewm":
            return np.full(len(TAU_WINDS), coefficients["tau"])
        if fit.dynamics == "steady":
            return np.full(len(TAU_WINDS), np.nan)
        return coefficients["capacity"] * steady.resistance_line(
            coefficients
        ).resistance(TAU_WINDS)

    def of_means(coefficients: dict) -> np.ndarray:
        # for means, tau is the mean age of the past, computed at the mean wind
        usual = taus(coefficients)[0]
        if fit.dynamics == "balance":
            at = np.nan if steady.measured is None else steady.measured.wind
            usual = coefficients["capacity"] * steady.resistance_line(
                coefficients
            ).resistance(at)
        return taus(coefficients) * (step / np.expm1(step / usual) / usual)

    step, tau = fit.summary.step, "tau = capacity r_eq(WS)"
    for convention, function, equation, source in (
        ("time constant", taus, tau, f"{HERTELEER}, Eq. 10"),
        (
            f"time constant, means over {step:g} s",
            of_means,
            f"{tau}, capacity by step / (exp(step / tau) - 1) at the mean wind",
            "this package's guide, Dynamics",
        ),
    ):
        values, errors = function(fit.coefficients), steady.error(function)
        like = dict(of="module", equation=equation, source=source)
        for wind, value, error in zip(TAU_WINDS, values, errors):
            at, said = f"at {wind:g} m/s", why
            if np.isnan(value) and fit.dynamics != "steady":
                said = "needs the record for its mean wind; give data"
            elif value < step:
                said = joined_notes(why, ROUGH)
            yield parameter_row(
                steady, convention, at, value, "s", error, np.nan, said, like
            )
