"""
The steady models, each as r_eq(wind_speed) = T_o / G: the paper's five, and pvlib's.

The over-temperature is ``poa_global * r_eq``, and the loss of the heat balance is
``1 / r_eq``. Each model has the slopes of its resistance by parameter and by wind
speed, which the exact Jacobian of a fit needs.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem._spelling import did_you_mean
from pvlib_fem.effects._effect import Parameter

CLIP = 8.0  # m/s, where the paper clips the wind in WM2
SHELTER = 0.51  # of SAM: wind at the module over wind at 10 m


RESISTANCE, LOGARITHM, LOSS = range(3)
#: from a resistance to the scale, and the scale's slope by it
SCALES = (
    lambda r_eq: (r_eq, 1.0),
    lambda r_eq: (np.log(r_eq), 1.0 / r_eq),
    lambda r_eq: (1.0 / r_eq, -1.0 / r_eq**2),
)


@dataclass(frozen=True)
class SteadyModel:
    """
    A steady model: its resistance, its slopes and its parameter rows.

    ``constants`` are rows of coefficients that a user may set and a fit does not vary;
    their start is the default, or NaN without one. ``defaults`` are the defaults of
    the parameters in pvlib's function of that name.
    """

    name: str
    resistance: Callable  # wind_speed, **coefficients -> r_eq [K/(W/m²)]
    slopes: Callable  # the same -> {coefficient or "wind_speed": slope of r_eq}
    parameters: Mapping[str, Parameter]
    constants: Mapping[str, Parameter] = field(default_factory=dict)
    defaults: Mapping[str, float] = field(default_factory=dict)
    scale: int = 0  # place in SCALES on which r_eq is a straight line in wind
    clip: str = ""  # coefficient: the wind speed from which r_eq is constant
    takes_wind: bool = True  # whether it depends on wind

    @property
    def coefficients(self) -> Any:
        """Names of all coefficients: first the fitted ones, then the constants."""
        return [*self.parameters, *self.constants]

    @property
    def fixed(self) -> dict:
        """Defaults of the constants that have one, by name."""
        rows = self.constants.items()
        return {name: row.start for name, row in rows if not np.isnan(row.start)}

    def complete(self, coefficients: dict) -> dict:
        """Check the names and values of coefficients, and add the defaults."""
        names = self.coefficients
        if unknown := [name for name in coefficients if name not in names]:
            raise ValueError(
                f"{self.name} has no coefficient {', '.join(unknown)}; it has "
                f"{', '.join(names)}"
            )
        complete = {**self.fixed, **self.defaults, **coefficients}
        if missing := [name for name in names if name not in complete]:
            raise ValueError(
                f"{self.name} needs {', '.join(missing)}; it has the coefficients "
                f"{', '.join(names)}"
            )
        check_values(self.name, complete)
        return complete


POSITIVE = ("k", "d", "u0", "wind_speed_max", "u_c", "alpha_absorption")
NUMBERS = (int, float, np.integer, np.floating)
SHARES = ("module_efficiency", "alpha_absorption", "transmittance_absorptance")


def check_values(name: Any, coefficients: dict) -> None:
    """Refuse values at which a steady model has no physical meaning."""
    for key, value in coefficients.items():
        if not isinstance(value, NUMBERS) or np.isnan(value):
            raise ValueError(f"{name}: {key} = {value!r} must be one number")
        if key in POSITIVE and not value > 0:
            raise ValueError(f"{name}: {key} = {value} must be positive")
        if key == "noct" and not value > 20.0:
            raise ValueError(f"{name}: noct = {value} must be above 20 °C, the air's")
        if key in SHARES and not 0.0 <= value <= 1.0:
            raise ValueError(f"{name}: {key} = {value} must be a share, 0 to 1")
    if "module_efficiency" in coefficients:
        absorbed = coefficients.get("transmittance_absorptance", 1.0)
        if not coefficients["module_efficiency"] < absorbed:
            raise ValueError(
                f"{name}: module_efficiency = {coefficients['module_efficiency']} must "
                f"be below {absorbed}, what is absorbed"
            )
    if "k_w" in coefficients:
        k, k_w, clip = (coefficients[c] for c in ("k", "k_w", "wind_speed_max"))
        if k_w * clip >= k:
            raise ValueError(
                f"wm2: k_w = {k_w:g} and k = {k:g} make the over-temperature zero or "
                f"negative from {k / k_w:.1f} m/s; k_w·{clip:g} must be below k"
            )


def ross(
    wind_speed: float | np.ndarray | pd.Series, k: float
) -> float | np.ndarray | pd.Series:
    return k + 0.0 * wind_speed


def ross_slopes(wind_speed: np.ndarray, k: float) -> dict[str, Any]:
    return {"k": np.ones_like(wind_speed), "wind_speed": 0.0}


def sapm(
    wind_speed: float | np.ndarray | pd.Series, a: float, b: float
) -> float | np.ndarray | pd.Series:
    return np.exp(a + b * wind_speed)


def sapm_slopes(wind_speed: np.ndarray, a: float, b: float) -> dict:
    r_eq = sapm(wind_speed, a, b)
    return {"a": r_eq, "b": wind_speed * r_eq, "wind_speed": b * r_eq}


def faiman(
    wind_speed: float | np.ndarray | pd.Series, u0: float, u1: float
) -> float | np.ndarray | pd.Series:
    return 1.0 / (u0 + u1 * wind_speed)


def faiman_slopes(wind_speed: np.ndarray, u0: float, u1: float) -> dict:
    square = faiman(wind_speed, u0, u1) ** 2
    return {"u0": -square, "u1": -wind_speed * square, "wind_speed": -u1 * square}


def wm1(
    wind_speed: float | np.ndarray | pd.Series, k: float, d: float
) -> float | np.ndarray | pd.Series:
    return k * np.exp(-wind_speed / d)


def wm1_slopes(wind_speed: np.ndarray, k: float, d: float) -> dict:
    r_eq = wm1(wind_speed, k, d)
    return {"k": r_eq / k, "d": wind_speed / d**2 * r_eq, "wind_speed": -r_eq / d}


def wm2(
    wind_speed: float | np.ndarray | pd.Series,
    k: float,
    k_w: float,
    wind_speed_max: float,
) -> float | np.ndarray | pd.Series:
    return k - k_w * np.minimum(wind_speed, wind_speed_max)


def wm2_slopes(
    wind_speed: np.ndarray, k: float, k_w: float, wind_speed_max: float
) -> dict:
    return {
        "k": np.ones_like(wind_speed),
        "k_w": -np.minimum(wind_speed, wind_speed_max),
        "wind_speed": np.where(wind_speed < wind_speed_max, -k_w, 0.0),
    }


def pvsyst_line(
    u_c: float, u_v: float, module_efficiency: float, alpha_absorption: float
) -> tuple[float, float]:
    """
    Loss per absorbed irradiance as a line in wind, Faiman's u0 and u1.

    Parameters
    ----------
    u_c : float
        Loss in calm air. [W/(m² K)]
    u_v : float
        Its increase with wind. [W s/(m³ K)]
    module_efficiency, alpha_absorption : float
        [-]

    Returns
    -------
    tuple of float
        u0 [W/(m² K)] and u1 [W s/(m³ K)].
    """
    absorbed = alpha_absorption * (1.0 - module_efficiency)
    return u_c / absorbed, u_v / absorbed


def pvsyst(
    wind_speed: float | np.ndarray | pd.Series, **coefficients: float
) -> float | np.ndarray | pd.Series:
    return faiman(wind_speed, *pvsyst_line(**coefficients))


def pvsyst_slopes(wind_speed: np.ndarray, **coefficients: float) -> dict:
    slopes = faiman_slopes(wind_speed, *pvsyst_line(**coefficients))
    per_loss, _ = pvsyst_line(**{**coefficients, "u_c": 1.0})
    return {
        "u_c": slopes["u0"] * per_loss,
        "u_v": slopes["u1"] * per_loss,
        "wind_speed": slopes["wind_speed"],
    }


def noct(
    wind_speed: float | np.ndarray | pd.Series, noct: float
) -> float | np.ndarray | pd.Series:
    return ross(wind_speed, (noct - 20.0) / 800.0)


def noct_slopes(wind_speed: np.ndarray, noct: float) -> dict[str, Any]:
    return {"noct": np.full_like(wind_speed, 1.0 / 800.0), "wind_speed": 0.0}


def noct_sam_line(
    noct: float, module_efficiency: float, transmittance_absorptance: float
) -> tuple[float, float]:
    """
    SAM's loss as a line in wind: 0.6 of it in calm air, 0.4 grow with the wind.

    Parameters
    ----------
    noct : float
        Above 20 °C. [°C]
    module_efficiency, transmittance_absorptance : float
        [-]

    Returns
    -------
    tuple of float
        Faiman's u0 [W/(m² K)] and u1 [W s/(m³ K)].
    """
    heat = 1.0 - module_efficiency / transmittance_absorptance
    loss = 800.0 / (noct - 20.0) / heat
    return 0.6 * loss, 0.4 * SHELTER * loss


def noct_sam(
    wind_speed: float | np.ndarray | pd.Series, **coefficients: float
) -> float | np.ndarray | pd.Series:
    return faiman(wind_speed, *noct_sam_line(**coefficients))


def noct_sam_slopes(wind_speed: np.ndarray, **coefficients: float) -> dict:
    u0, u1 = noct_sam_line(**coefficients)
    r_eq = faiman(wind_speed, u0, u1)
    by_wind = faiman_slopes(wind_speed, u0, u1)["wind_speed"]
    return {"noct": r_eq / (coefficients["noct"] - 20.0), "wind_speed": by_wind}


# starts are the paper's average site (its Table 3) and pvlib's defaults
K = Parameter(0.0326, 0.002, 0.2, "K m²/W")

SHARE: dict[str, Any] = {"lower": 0.0, "upper": 1.0, "unit": "-"}

STEADY_MODELS = {
    "ross": SteadyModel("ross", ross, ross_slopes, {"k": K}, takes_wind=False),
    "sapm": SteadyModel(
        "sapm",
        sapm,
        sapm_slopes,
        {
            "a": Parameter(-3.47, -6.2, -1.6, "ln(K m²/W)"),
            "b": Parameter(-0.0594, -1.0, 0.0, "s/m"),
        },
        scale=LOGARITHM,
    ),
    "faiman": SteadyModel(
        "faiman",
        faiman,
        faiman_slopes,
        {
            "u0": Parameter(25.0, 1.0, 500.0, "W/(m² K)"),
            "u1": Parameter(6.84, 0.0, 100.0, "W s/(m³ K)"),
        },
        defaults={"u0": 25.0, "u1": 6.84},
        scale=LOSS,
    ),
    "wm1": SteadyModel(
        "wm1",
        wm1,
        wm1_slopes,
        {"k": K, "d": Parameter(15.0, 1.0, 1000.0, "m/s")},
        scale=LOGARITHM,
    ),
    "wm2": SteadyModel(
        "wm2",
        wm2,
        wm2_slopes,
        {
            "k": K,
            "k_w": Parameter(0.5 / CLIP, 0.0, 0.999 / CLIP, "K m s/W", share_of="k"),
        },
        {"wind_speed_max": Parameter(CLIP, 0.0, CLIP, "m/s")},
        clip="wind_speed_max",
    ),
    "pvsyst": SteadyModel(
        "pvsyst",
        pvsyst,
        pvsyst_slopes,
        {
            "u_c": Parameter(29.0, 1.0, 500.0, "W/(m² K)"),
            "u_v": Parameter(1.0, 0.0, 100.0, "W s/(m³ K)"),
        },
        {
            "module_efficiency": Parameter(0.1, **SHARE),
            "alpha_absorption": Parameter(0.9, **SHARE),
        },
        defaults={"u_c": 29.0, "u_v": 0.0},
        scale=LOSS,
    ),
    "noct": SteadyModel(
        "noct",
        noct,
        noct_slopes,
        {"noct": Parameter(46.0, 21.6, 180.0, "°C")},
        takes_wind=False,
    ),
    "noct_sam": SteadyModel(
        "noct_sam",
        noct_sam,
        noct_sam_slopes,
        {"noct": Parameter(46.0, 21.6, 180.0, "°C")},
        {
            "module_efficiency": Parameter(np.nan, **SHARE),
            "transmittance_absorptance": Parameter(0.9, **SHARE),
        },
        scale=LOSS,
    ),
}


def steady_model(model: str, given: dict | tuple = ()) -> SteadyModel:
    """
    The steady model of that name; ``"noct"`` for ``"ross"`` with a NOCT given.

    Parameters
    ----------
    model : str
    given : collection of str, optional
        Names of the given coefficients.

    Returns
    -------
    SteadyModel

    Raises
    ------
    ValueError
        If there is no such model.
    """
    if model == "ross" and "noct" in given:
        model = "noct"
    if not isinstance(model, str) or model not in STEADY_MODELS:
        raise ValueError(
            f"unknown model {model!r}{did_you_mean(str(model), STEADY_MODELS)}; the "
            f"models are {', '.join(STEADY_MODELS)}"
        )
    return STEADY_MODELS[model]
