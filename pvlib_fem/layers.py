"""The RC stack of a module: from its layers to resistance, capacity and time."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import pandas as pd

__all__ = [
    "Layer",
    "glass_tedlar",
    "stack",
]


@dataclass(frozen=True)
class Layer:
    """
    One layer of a module, or the air film on it.

    Parameters
    ----------
    name : str
        Name in the table.
    thickness : float
        Along the flow of heat. [m]
    conductivity : float
        Thermal conductivity. [W/(m K)]
    density : float
        [kg/m³]
    heat_capacity : float
        Specific heat capacity. [J/(kg K)]
    area : float, default 1
        Area that it covers, for its mass. [m²]
    is_film : bool, default False
        Whether it is an air film; the totals without air do not count it.
    """

    name: str
    thickness: float
    conductivity: float
    density: float
    heat_capacity: float
    area: float = 1.0
    is_film: bool = False

    def __post_init__(self) -> None:
        if not self.thickness >= 0:
            raise ValueError(
                f"{self.name}: thickness = {self.thickness} must be 0 or positive"
            )
        for name in ("conductivity", "density", "heat_capacity", "area"):
            if not getattr(self, name) > 0:
                raise ValueError(
                    f"{self.name}: {name} = {getattr(self, name)} must be positive"
                )

    @property
    def resistance(self) -> float:
        """Thickness over conductivity. [K m²/W]"""
        return self.thickness / self.conductivity

    @property
    def capacity(self) -> float:
        """Heat capacity per area. [J/(m² K)]"""
        return self.density * self.heat_capacity * self.thickness

    @property
    def mass(self) -> float:
        """[kg]"""
        return self.density * self.thickness * self.area


def stack(front: Iterable[Layer], back: Iterable[Layer]) -> pd.DataFrame:
    r"""
    Resistance, capacity and time constant of each layer and of their stacks.

    Layers of one side are in series, the two sides in parallel, and
    :math:`\tau = r\,c` [1]_.

    Parameters
    ----------
    front, back : iterable of Layer
        Layers of a side, from its outside to the cells.

    Returns
    -------
    DataFrame
        A row for each layer, then ``front``, ``back`` and ``total`` without
        the air films and ``front + air``, ``back + air`` and ``total + air``
        with them; columns ``mass`` [kg], ``r`` [K m²/W], ``c`` [J/(m² K)],
        ``tau`` [s].

    Raises
    ------
    ValueError
        If a side has no layer other than air films.

    References
    ----------
    .. [1] B. Herteleer et al., "Investigating methods to improve photovoltaic
       thermal models at second-to-minute timescales", 2022, Eqs. 6 to 10.
       :doi:`10.22541/au.166922866.68736478`

    Examples
    --------
    >>> table = stack(*glass_tedlar())
    >>> print(round(table.loc["total + air", "tau"], 1))
    590.6
    """
    front, back = tuple(front), tuple(back)
    rows = [
        row(layer.name, layer.resistance, layer.capacity, layer.mass)
        for layer in (*front, *back)
    ]
    for air in (False, True):
        suffix = " + air" if air else ""
        sides = []
        for name, side in (("front", front), ("back", back)):
            layers = [layer for layer in side if air or not layer.is_film]
            if not any(not layer.is_film for layer in layers):
                raise ValueError(f"{name} has no layer other than its air film")
            r = sum(layer.resistance for layer in layers)
            c = sum(layer.capacity for layer in layers)
            m = sum(layer.mass for layer in layers)
            sides.append((r, c, m))
            rows.append(row(name + suffix, r, c, m))
        (r1, c1, m1), (r2, c2, m2) = sides
        rows.append(row("total" + suffix, 1 / (1 / r1 + 1 / r2), c1 + c2, m1 + m2))
    return pd.DataFrame(rows).set_index("layer")


def row(name: Any, r: Any, c: Any, mass: Any) -> Any:
    return {"layer": name, "mass": mass, "r": r, "c": c, "tau": r * c}


def glass_tedlar(
    back_film: float = 1.5e-3, frame: float = 2e-3
) -> tuple[tuple[Layer, ...], tuple[Layer, ...]]:
    """
    The paper's representative glass-Tedlar module [1]_.

    Parameters
    ----------
    back_film : float, default 1.5e-3
        Thickness of the air film on the back; for a module on a roof it is
        4.2e-3. [m]
    frame : float, default 2e-3
        Thickness of the aluminium frame; 0 leaves it out. The paper's total counts
        its capacity by its own area, 0.296 m² a side; by the module's 1.6 m² c would
        be 9.4 kJ/(m² K) instead of 17.3, and tau 320 s instead of 591. [m]

    Returns
    -------
    front, back : tuple of Layer

    References
    ----------
    .. [1] B. Herteleer et al., "Investigating methods to improve photovoltaic
       thermal models at second-to-minute timescales", 2022, Table 1.
       :doi:`10.22541/au.166922866.68736478`
    """
    area, frame_area = 1.6, 0.296

    def film(name: Any, thickness: Any) -> Any:
        return Layer(name, thickness, 0.023, 1.23, 1000.0, area, is_film=True)

    def aluminium(name: Any) -> Any:
        return Layer(name, frame, 237.0, 2700.0, 900.0, frame_area)

    cells = Layer("cells", 0.1e-3, 148.0, 2330.0, 677.0, area)
    eva = Layer("EVA", 0.5e-3, 0.35, 960.0, 2090.0, area)
    front = (
        film("air film, front", 1.5e-3),
        aluminium("frame, front"),
        Layer("glass", 3.2e-3, 1.8, 3000.0, 500.0, area),
        eva,
        cells,
    )
    back = (
        film("air film, back", back_film),
        aluminium("frame, back"),
        Layer("Tedlar", 0.3e-3, 0.2, 1200.0, 1250.0, area),
        eva,
        cells,
    )
    return front, back
