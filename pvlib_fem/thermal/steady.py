"""
The five steady models of the paper, each as r_eq(wind_speed) = T_o / G.

They differ in nothing else: over-temperature is ``poa_global * r_eq``, and the
loss of the heat balance is ``1 / r_eq``. Beside each resistance stand its
slopes, by parameter and by wind speed, which the exact Jacobian of a fit needs.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from pvlib_fem.effects.effect import Parameter

CLIP = 8.0  # m/s, where the paper clips the wind in WM2


@dataclass(frozen=True)
class SteadyModel:
    """
    A steady model: its resistance, its slopes and its parameter rows.

    ``fixed`` are constants of the steady model with their defaults, which a user may
    set and a fit leaves alone.
    """

    name: str
    resistance: Callable  # wind_speed, **coefficients -> r_eq [K/(W/m²)]
    slopes: Callable  # the same -> {coefficient or "wind_speed": slope of r_eq}
    parameters: Mapping[str, Parameter]
    fixed: Mapping[str, float]

    @property
    def coefficients(self):
        """Names of all coefficients: those that are fitted, then the constants."""
        return [*self.parameters, *self.fixed]

    def complete(self, coefficients):
        """Check the names and values of coefficients, and add the fixed ones."""
        names = self.coefficients
        if unknown := [name for name in coefficients if name not in names]:
            raise ValueError(
                f"{self.name} has no coefficient {', '.join(unknown)}; it has "
                f"{', '.join(names)}"
            )
        if missing := [name for name in self.parameters if name not in coefficients]:
            raise ValueError(
                f"{self.name} needs {', '.join(missing)}; it has the coefficients "
                f"{', '.join(names)}"
            )
        complete = {**self.fixed, **coefficients}
        check_values(self.name, complete)
        return complete


def check_values(name, coefficients):
    """Refuse values at which a steady model is no longer one."""
    for key, value in coefficients.items():
        if not np.isscalar(value) or np.isnan(value):
            raise ValueError(f"{name}: {key} = {value!r} must be one number")
        if key in ("k", "d", "u0", "wind_speed_max") and not value > 0:
            raise ValueError(f"{name}: {key} = {value} must be positive")
    if "k_w" in coefficients:
        k, k_w, clip = (coefficients[c] for c in ("k", "k_w", "wind_speed_max"))
        if k_w * clip >= k:
            raise ValueError(
                f"wm2: k_w = {k_w:g} and k = {k:g} make the over-temperature zero or "
                f"negative from {k / k_w:.1f} m/s; k_w·{clip:g} must be below k"
            )


def ross(wind_speed, k):
    return k + 0.0 * wind_speed


def ross_slopes(wind_speed, k):
    return {"k": np.ones_like(wind_speed), "wind_speed": 0.0}


def sapm(wind_speed, a, b):
    return np.exp(a + b * wind_speed)


def sapm_slopes(wind_speed, a, b):
    r_eq = sapm(wind_speed, a, b)
    return {"a": r_eq, "b": wind_speed * r_eq, "wind_speed": b * r_eq}


def faiman(wind_speed, u0, u1):
    return 1.0 / (u0 + u1 * wind_speed)


def faiman_slopes(wind_speed, u0, u1):
    square = faiman(wind_speed, u0, u1) ** 2
    return {"u0": -square, "u1": -wind_speed * square, "wind_speed": -u1 * square}


def wm1(wind_speed, k, d):
    return k * np.exp(-wind_speed / d)


def wm1_slopes(wind_speed, k, d):
    r_eq = wm1(wind_speed, k, d)
    return {"k": r_eq / k, "d": wind_speed / d**2 * r_eq, "wind_speed": -r_eq / d}


def wm2(wind_speed, k, k_w, wind_speed_max):
    return k - k_w * np.minimum(wind_speed, wind_speed_max)


def wm2_slopes(wind_speed, k, k_w, wind_speed_max):
    return {
        "k": np.ones_like(wind_speed),
        "k_w": -np.minimum(wind_speed, wind_speed_max),
        "wind_speed": np.where(wind_speed < wind_speed_max, -k_w, 0.0),
    }


# starts are the paper's average site (its Table 3) and pvlib's defaults
K = Parameter(0.0326, 0.002, 0.2, "K m²/W")

STEADY_MODELS = {
    "ross": SteadyModel("ross", ross, ross_slopes, {"k": K}, {}),
    "sapm": SteadyModel(
        "sapm",
        sapm,
        sapm_slopes,
        {
            "a": Parameter(-3.47, -6.2, -1.6, "ln(K m²/W)"),
            "b": Parameter(-0.0594, -1.0, 0.0, "s/m"),
        },
        {},
    ),
    "faiman": SteadyModel(
        "faiman",
        faiman,
        faiman_slopes,
        {
            "u0": Parameter(25.0, 1.0, 500.0, "W/(m² K)"),
            "u1": Parameter(6.84, 0.0, 100.0, "W s/(m³ K)"),
        },
        {},
    ),
    "wm1": SteadyModel(
        "wm1",
        wm1,
        wm1_slopes,
        {"k": K, "d": Parameter(15.0, 1.0, 1000.0, "m/s")},
        {},
    ),
    "wm2": SteadyModel(
        "wm2",
        wm2,
        wm2_slopes,
        {
            "k": K,
            "k_w": Parameter(0.5 / CLIP, 0.0, 0.999 / CLIP, "K m s/W", share_of="k"),
        },
        {"wind_speed_max": CLIP},
    ),
}


def steady_model(model):
    """The steady model of that name."""
    if not isinstance(model, str) or model not in STEADY_MODELS:
        raise ValueError(
            f"unknown model {model!r}; the models are {', '.join(STEADY_MODELS)}"
        )
    return STEADY_MODELS[model]
