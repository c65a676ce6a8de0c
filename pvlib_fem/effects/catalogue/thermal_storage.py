"""A second, slower mass: a roof, the ground, a frame."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import nnls

from pvlib_fem._spelling import did_you_mean
from pvlib_fem.effects._effect import Effect, Parameter, Terms
from pvlib_fem.effects._scans import beyond_others
from pvlib_fem.reasons import Reason


def terms(
    poa_stored_1h: np.ndarray,
    poa_stored_3h: np.ndarray,
    air_stored: np.ndarray,
    *,
    hour: float = 0.0,
    three_hours: float = 0.0,
    air: float = 0.0,
) -> Terms:
    r"""
    Heat that a slow mass stores in the morning and releases in the evening [1]_.

    .. math::

        \mathrm{heat} = \mathrm{hour} \cdot \mathrm{poa\_stored\_1h}
        + \mathrm{three\_hours} \cdot \mathrm{poa\_stored\_3h}
        + \mathrm{air} \cdot \mathrm{air\_stored}

    ``hour`` and ``three_hours`` are shares of irradiance, by the time constant of the
    mass; ``air`` is its heat exchange with the module per kelvin of change of the air.
    A mass gives back what it has taken, so that none is negative: the scan takes the
    parts that the record shows, and the others are zero.

    References
    ----------
    .. [1] P. Bacher and H. Madsen, "Identifying suitable models for the heat
       dynamics of buildings", Energy and Buildings 43, 1511 (2011),
       :doi:`10.1016/j.enbuild.2011.02.005`: models of one mass and of more.
    """
    return Terms(
        heat=hour * poa_stored_1h + three_hours * poa_stored_3h + air * air_stored
    )


PARTS = {
    "hour": Parameter(0.0, -0.1, 0.8, "-"),
    "three_hours": Parameter(0.0, -0.1, 0.8, "-"),
    "air": Parameter(0.0, -5.0, 20.0, "W/(m² K)"),
}


def of_parts(parts: str | Sequence[str] = tuple(PARTS)) -> Effect:
    """The effect with one or some of its parts."""
    parts = (parts,) if isinstance(parts, str) else parts
    if not parts:
        raise ValueError(f"thermal_storage needs a part; it has {', '.join(PARTS)}")
    if unknown := [name for name in parts if name not in PARTS]:
        raise ValueError(
            f"thermal_storage has no part {', '.join(map(repr, unknown))}"
            f"{did_you_mean(unknown, PARTS)}; it has {', '.join(PARTS)}"
        )
    rows = {name: PARTS[name] for name in PARTS if name in parts}
    return replace(EFFECT.unscanned, parameters=rows, settings={"parts": tuple(rows)})


def scan(
    rest: np.ndarray, tangents: dict, columns: dict, weeks: np.ndarray, least: float
) -> Effect | None:
    """The effect with those parts that are positive in the best fit of all."""
    keys = [f"thermal_storage.{name}" for name in PARTS]
    sizes, _ = nnls(beyond_others(tangents, keys), rest)
    parts = [name for name, size in zip(PARTS, sizes) if size > 0.0]
    return of_parts(parts) if parts else None


EFFECT = Effect(
    "thermal_storage",
    terms,
    PARTS,
    confounder=True,
    title="heat stored behind the modules",
    decided_by="a temperature sensor on the roof or in the cavity behind",
    confused_with=(
        "poa_misalignment",
        "natural_convection",
        "season",
        "temperature_gain",
        "a clock that is late",
        "the capacity, or the time constant",
    ),
    make=of_parts,
    scan=scan,
    not_found=Reason.NO_STORAGE,
)
