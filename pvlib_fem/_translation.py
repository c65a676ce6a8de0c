"""
Translate coefficients of one steady model to another.

Every model here is a resistance r(wind_speed) = T_o / G. The translation is
exact for ross, noct and the k of the others in calm air, between sapm and wm1, and
between faiman and pvsyst. Other pairs differ in shape, and a rule must choose.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from pvlib_fem._thermal.steady_models import (
    CLIP,
    SHELTER,
    STEADY_MODELS,
    noct_sam_line,
    pvsyst_line,
)

TWO_WINDS = (1.4, 5.4)  # m/s, as pvlib's GenericLinearModel
METHODS = ("two_winds", "least_squares", "calm")
CARRIED = ("tau", "capacity", "bias")  # copied unchanged
SUN = 1000.0  # W/m²

# Weibull distribution with 90 % of the wind speeds below 5 m/s, as in the paper; the
# shape of 2 is the package's choice
QUANTILES = (np.arange(100) + 0.5) / 100
USUAL_WINDS = 5.0 / np.sqrt(np.log(10.0)) * np.sqrt(-np.log1p(-QUANTILES))


@dataclass(frozen=True)
class Shape:
    """
    A model as a line in wind: ``bend(r) = first + second·wind_speed``.

    ``unbend`` is the inverse of ``bend`` and ``slope`` its derivative.
    """

    bend: Callable
    unbend: Callable
    slope: Callable
    line: Callable  # coefficients -> (first, second)
    coefficients: Callable  # (first, second), fixed -> coefficients
    names: tuple
    fixed: dict  # None: must be given
    clip: str = ""  # coefficient: wind speed beyond which more has no influence
    ratio: float | None = None  # second/first where the model fixes it

    def resistance(self, wind_speed: float | np.ndarray, coefficients: dict) -> Any:
        first, second = self.line(**coefficients)
        seen = np.minimum(wind_speed, self.limit(coefficients))
        return self.unbend(first + second * seen)

    def limit(self, coefficients: dict) -> float:
        """Wind speed beyond which more has no influence; infinite without one."""
        return {**self.fixed, **coefficients}[self.clip] if self.clip else np.inf


def pvsyst_coefficients(
    first: float, second: float, module_efficiency: float, alpha_absorption: float
) -> dict:
    absorbed = alpha_absorption * (1.0 - module_efficiency)
    return {"u_c": first * absorbed, "u_v": second * absorbed}


def noct_sam_coefficients(
    first: float,
    second: float,
    module_efficiency: float,
    transmittance_absorptance: float,
) -> dict:
    heat = 1.0 - module_efficiency / transmittance_absorptance
    return {"noct": 20.0 + 800.0 * 0.6 / (first * heat)}


def wm1_coefficients(first: float, second: float) -> dict:
    return {"k": np.exp(first), "d": -1.0 / second if second else np.inf}


def reciprocal(value: float | np.ndarray) -> float | np.ndarray:
    """
    Loss of a resistance, or resistance of a loss.

    Parameters
    ----------
    value : float or array
        Resistance r [K m²/W] or loss [W/(m² K)].

    Returns
    -------
    float or array
        Of the shape of ``value``.
    """
    return 1.0 / value


def identity(value: float | np.ndarray) -> float | np.ndarray:
    return value


LOSS = (reciprocal, reciprocal, lambda r: -1.0 / r**2)
LOGARITHM = (np.log, np.exp, reciprocal)
PLAIN = (identity, identity, lambda r: 1.0)

SHAPES = {
    "ross": Shape(
        *PLAIN, lambda k: (k, 0.0), lambda p, q: {"k": p}, ("k",), {}, ratio=0.0
    ),
    "noct": Shape(
        *PLAIN,
        lambda noct: ((noct - 20.0) / 800.0, 0.0),
        lambda p, q: {"noct": 20.0 + 800.0 * p},
        ("noct",),
        {},
        ratio=0.0,
    ),
    "sapm": Shape(
        *LOGARITHM,
        lambda a, b: (a, b),
        lambda p, q: {"a": p, "b": q},
        ("a", "b"),
        {},
    ),
    "wm1": Shape(
        *LOGARITHM,
        lambda k, d: (np.log(k), -1.0 / d),
        wm1_coefficients,
        ("k", "d"),
        {},
    ),
    "faiman": Shape(
        *LOSS,
        lambda u0, u1: (u0, u1),
        lambda p, q: {"u0": p, "u1": q},
        ("u0", "u1"),
        {},
    ),
    "wm2": Shape(
        *PLAIN,
        lambda k, k_w, wind_speed_max=CLIP: (k, -k_w),
        lambda p, q, wind_speed_max: {"k": p, "k_w": 0.0 - q},
        ("k", "k_w"),
        {"wind_speed_max": CLIP},
        clip="wind_speed_max",
    ),
    "pvsyst": Shape(
        *LOSS,
        pvsyst_line,
        pvsyst_coefficients,
        ("u_c", "u_v"),
        {"module_efficiency": 0.1, "alpha_absorption": 0.9},
    ),
    "noct_sam": Shape(
        *LOSS,
        noct_sam_line,
        noct_sam_coefficients,
        ("noct",),
        {"module_efficiency": None, "transmittance_absorptance": 0.9},
        ratio=0.4 * SHELTER / 0.6,
    ),
}


def translate_coefficients(
    coefficients: Mapping[str, float],
    source: str,
    target: str,
    method: str = "two_winds",
    wind_speed: Sequence[float] | np.ndarray | None = None,
    **fixed: float,
) -> dict:
    """
    Translate coefficients between steady models.

    Parameters
    ----------
    coefficients : dict
        Coefficients of the source. ``tau``, ``capacity`` and ``bias`` are copied
        unchanged.
    source, target : str
        ``"ross"``, ``"noct"`` (Ross's model by its NOCT), ``"sapm"``,
        ``"faiman"``, ``"wm1"``, ``"wm2"``, ``"pvsyst"`` or ``"noct_sam"``.
    method : str, default "two_winds"
        Wind speeds at which both models agree. ``"two_winds"``: at the 1.4 and 5.4 m/s
        of pvlib's ``GenericLinearModel`` [2]_ (``noct_sam``, whose wind slope is
        fixed, at 1/0.51 m/s, and ``ross`` in their mean). ``"least_squares"``: least
        mean square over ``wind_speed``. ``"calm"``: at 0 m/s, the paper's k = e^a =
        1/u0 [1]_; that the slopes agree there, too, is this package's choice.
    wind_speed : array, optional
        Wind speeds for ``"least_squares"``, which other methods do not use; by default
        a Weibull distribution with 90 % below 5 m/s, as in the paper, and of shape 2,
        which is this package's choice. [m/s]
    **fixed
        Constants of the target: ``module_efficiency`` and ``alpha_absorption`` of
        pvsyst (by default pvlib's 0.1 and 0.9), ``module_efficiency`` (required)
        and ``transmittance_absorptance`` (0.9) of noct_sam, ``wind_speed_max`` of wm2
        (8 m/s).

    Returns
    -------
    dict
        Coefficients, which unpack into the target's function. They include its
        constants, ``wind_speed_max`` only if it is not the default.

    Raises
    ------
    ValueError
        If a name is unknown, a coefficient missing, the wind speeds do not determine
        the target, or it cannot have that shape (wm2 with ``8·k_w >= k``, a model that
        wind heats).

    See Also
    --------
    translation_mismatch : the difference between source and target, in K.

    Notes
    -----
    If shapes differ, ``"calm"`` matches a wind speed that is rare at modules. Faiman's
    usual coefficients, translated to Sandia's, differ by 6.2 K (rms from 0 to 10 m/s at
    1000 W/m²); by ``"two_winds"`` they differ by 1.4 K.

    pvsyst and noct_sam give cell temperatures, the others temperatures of the back of
    the module. The translation does not correct this difference, some 3 K at
    1000 W/m² on open racks.

    References
    ----------
    .. [1] B. Herteleer et al., "Investigating methods to improve photovoltaic
       thermal models at second-to-minute timescales", 2022, Eq. 12.
       :doi:`10.22541/au.166922866.68736478`
    .. [2] A. Driesse et al., "PV Module Operating Temperature Model Equivalence
       and Parameter Translation", 49th IEEE Photovoltaic Specialists Conference,
       2022.

    Examples
    --------
    >>> {k: round(float(v), 4) for k, v in translate_coefficients(
    ...     {"u0": 25.0, "u1": 6.84}, "faiman", "sapm").items()}
    {'a': -3.3391, 'b': -0.1457}
    """
    carried = {name: coefficients[name] for name in CARRIED if name in coefficients}
    own = {name: v for name, v in coefficients.items() if name not in CARRIED}
    if method not in METHODS:
        raise ValueError(f"unknown method {method!r}; they are {', '.join(METHODS)}")
    start, own = completed_shape(source, own)
    goal = shape(target)
    own_limit = source == target and goal.clip and goal.clip not in fixed
    if own_limit:
        fixed = {goal.clip: own[goal.clip]}
    fixed = completed_fixed(target, goal, fixed)
    if source == target and (own_limit or not fixed):
        return {**without_default(own), **carried}
    winds = USUAL_WINDS if wind_speed is None else wind_speeds(wind_speed)
    limit = goal.limit(fixed)
    if method == "calm":
        line = at_calm(start, own, goal)
    elif method == "two_winds":
        line = at_two_winds(start, own, goal, limit)
    else:
        refuse_one_wind(winds, goal, limit)
        line = at_winds(start, own, goal, winds, limit)
    first, second = (float(value) + 0.0 for value in line)  # no -0.0
    if (second < 0) if goal.bend is reciprocal else (second > 0):
        raise ValueError(f"{source} {own} gains heat from wind; {target} cannot")
    result = {k: float(v) for k, v in goal.coefficients(first, second, **fixed).items()}
    if target in STEADY_MODELS:
        try:
            STEADY_MODELS[target].complete({**result, **fixed})
        except ValueError as error:
            others = " or ".join(repr(m) for m in METHODS if m not in (method, "calm"))
            raise ValueError(
                f"{method!r} translates {source} {own} into no {target}: {error}; "
                f"try method={others}"
            ) from error
    return {**result, **without_default(fixed), **carried}


def without_default(coefficients: dict) -> dict:
    """The coefficients without the usual limit of wm2, which its functions know."""
    usual = coefficients.get("wind_speed_max") == CLIP
    return {n: v for n, v in coefficients.items() if n != "wind_speed_max" or not usual}


def wind_speeds(given: Sequence[float] | np.ndarray) -> np.ndarray:
    """Checked wind speeds of a user: numbers from 0 m/s."""
    winds = np.atleast_1d(np.asarray(given, dtype=float))
    if not len(winds) or not np.isfinite(winds).all() or (winds < 0).any():
        raise ValueError(
            f"wind_speed = {given!r} must be one or more numbers of m/s, not negative "
            "and none of them NaN"
        )
    return winds


def refuse_one_wind(winds: np.ndarray, goal: Shape, limit: float) -> None:
    """Refuse wind speeds that do not determine the target's line in wind."""
    seen = np.minimum(winds, limit)
    if goal.ratio is None and np.linalg.matrix_rank(np.vander(seen, 2)) < 2:
        below = f" below {goal.clip}, {limit:g} m/s" if goal.clip else ""
        raise ValueError(
            f"wind_speed = {winds.tolist()} m/s does not determine "
            f"{' and '.join(goal.names)}; give wind speeds that differ{below}"
        )


@dataclass(frozen=True)
class Mismatch:
    """Disagreement of two models at 1000 W/m². [K]"""

    worst: float  # target minus source at the largest difference [K]
    rms: float  # over the wind speeds [K]
    wind_speed: float  # at the largest difference [m/s]


def translation_mismatch(
    coefficients: Mapping[str, float],
    source: str,
    target: str,
    method: str = "two_winds",
    wind_speed: Sequence[float] | np.ndarray | None = None,
    translated: Mapping[str, float] | None = None,
    **fixed: float,
) -> Mismatch:
    """
    Difference of a translated model from its source at 1000 W/m², over wind speeds.

    Parameters
    ----------
    coefficients, source, target, method, **fixed
        See :func:`translate_coefficients`.
    wind_speed : array, optional
        Wind speeds to compare at; 0 to 10 m/s by default. [m/s]
    translated : dict, optional
        Coefficients of the target to compare with, instead of translating.

    Returns
    -------
    Mismatch
        [K]

    Raises
    ------
    ValueError
        As :func:`translate_coefficients`, or if a wind speed is negative or NaN.

    Examples
    --------
    >>> faiman = {"u0": 25.0, "u1": 6.84}
    >>> mismatch = translation_mismatch(faiman, "faiman", "sapm")
    >>> print(round(mismatch.rms, 1), round(mismatch.worst, 1))
    1.4 -4.5
    """
    if translated is None:
        translated = translate_coefficients(
            coefficients, source, target, method, None, **fixed
        )
    winds = np.linspace(0, 10, 101) if wind_speed is None else wind_speeds(wind_speed)
    difference = np.zeros(winds.shape)
    for name, values, sign in ((target, translated, 1.0), (source, coefficients, -1.0)):
        values = {k: v for k, v in values.items() if k not in CARRIED}
        model, values = completed_shape(name, values)
        difference = difference + sign * SUN * model.resistance(winds, values)
    worst = int(np.argmax(np.abs(difference)))
    return Mismatch(
        worst=float(difference[worst]),
        rms=float(np.sqrt(np.mean(difference**2))),
        wind_speed=float(winds[worst]),
    )


def shape(model: str) -> Any:
    if model not in SHAPES:
        raise ValueError(f"unknown model {model!r}; there are {', '.join(SHAPES)}")
    return SHAPES[model]


def completed_shape(model: str, coefficients: dict) -> Any:
    """The shape of a model and its coefficients with the fixed ones."""
    if model == "ross" and "noct" in coefficients:
        model = "noct"
    form = shape(model)
    names = [*form.names, *form.fixed]
    if unknown := [name for name in coefficients if name not in names]:
        cell = "; deltaT leads from the back to the cell, leave it out here"
        hint = cell if "deltaT" in unknown else ""
        raise ValueError(
            f"{model} has no coefficient {', '.join(unknown)}; it has "
            f"{', '.join(names)}{hint}"
        )
    complete = {**form.fixed, **coefficients}
    missing = [n for n in (*form.names, *form.fixed) if complete.get(n) is None]
    if missing:
        raise ValueError(f"{model} needs {', '.join(missing)}")
    if model in STEADY_MODELS:
        STEADY_MODELS[model].complete(coefficients)
    return form, complete


def completed_fixed(target: str, goal: Shape, fixed: dict) -> dict:
    if unknown := [name for name in fixed if name not in goal.fixed]:
        raise ValueError(
            f"{target} has no constant {', '.join(unknown)}; it has "
            f"{', '.join(goal.fixed) or 'none'}"
        )
    complete = {**goal.fixed, **fixed}
    if missing := [name for name, value in complete.items() if value is None]:
        raise ValueError(f"{target} needs {', '.join(missing)}")
    return complete


def at_calm(start: Shape, own: dict, goal: Shape) -> tuple[float, float]:
    """The line of the target whose resistance and slope agree at 0 m/s."""
    first, second = start.line(**own)
    calm = start.unbend(first)
    fall = second / start.slope(calm)
    if goal.ratio is not None:
        return goal.bend(calm), goal.ratio * goal.bend(calm)
    return goal.bend(calm), goal.slope(calm) * fall


def at_two_winds(
    start: Any, own: dict, goal: Shape, limit: float = np.inf
) -> tuple[float, float]:
    """The line of the target that agrees at two winds, or at one if it has no slope."""
    if goal.ratio == 0.0:
        return np.mean(start.resistance(np.array(TWO_WINDS), own)), 0.0
    if goal.ratio is not None:
        # as pvlib: first the loss as a line, then agreement at the wind that SAM's
        # shelter factor reduces to 1 m/s at the module
        first, second = at_two_winds(start, own, SHAPES["faiman"])
        wind = 1.0 / SHELTER
        first = (first + second * wind) / (1.0 + goal.ratio * wind)
        return first, goal.ratio * first
    low, high = (goal.bend(start.resistance(wind, own)) for wind in TWO_WINDS)
    first, last = (min(wind, limit) for wind in TWO_WINDS)
    if not first < last:
        raise ValueError(
            f"wind_speed_max = {limit:g} m/s must be above {TWO_WINDS[0]:g} m/s, the "
            "lower of the two winds at which the models agree"
        )
    second = (high - low) / (last - first)
    return low - second * first, second


def at_winds(
    start: Any, own: dict, goal: Shape, winds: np.ndarray, limit: float = np.inf
) -> np.ndarray | tuple[float, float]:
    """
    The line of the target by least squares of the over-temperature at 1000 W/m².

    Parameters
    ----------
    start : Shape
        Model to translate, or any object with its method ``resistance``.
    own : dict
        Coefficients of ``start`` by name.
    goal : Shape
        Target.
    winds : array, shape (winds,)
        Wind speeds that count alike. [m/s]
    limit : float, optional
        Wind speed beyond which more has no influence on the target. [m/s]

    Returns
    -------
    tuple or array of float, shape (2,)
        ``first`` and ``second`` of :class:`Shape`, per m/s the latter.
    """
    wanted = start.resistance(winds, own)
    seen = np.minimum(winds, limit)
    begin = np.array(at_two_winds(start, own, goal, limit))
    if goal.ratio is not None:
        begin = begin[:1]

    def mismatch(line: np.ndarray) -> np.ndarray:
        second = goal.ratio * line[0] if goal.ratio is not None else line[1]
        return SUN * (goal.unbend(line[0] + second * seen) - wanted)

    scale = np.maximum(np.abs(begin), 1e-3)
    solved = least_squares(mismatch, begin, x_scale=scale, xtol=1e-14, ftol=1e-14).x
    return (solved[0], goal.ratio * solved[0]) if goal.ratio is not None else solved
