"""A dynamic cell temperature for ``pvlib.modelchain.ModelChain``."""

import inspect
import warnings
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np
import pandas as pd

from pvlib_fem._record.column_names import GEOMETRY
from pvlib_fem._relaxation import ewm
from pvlib_fem._stored import Stored, opened
from pvlib_fem._thermal.model import INSTANT, ThermalModel, refuse_tau, thermal_model
from pvlib_fem._thermal.model_files import model_of
from pvlib_fem._thermal.steady_models import steady_model
from pvlib_fem._thermal.temperature import TAU, fem_temperature, refuse_dynamic
from pvlib_fem.drivers import sun
from pvlib_fem.effects import EffectLike, find, several
from pvlib_fem.types import FilePath

FIT, LOOP = "pvlib_fem.FemFit", "pvlib_fem.Loop"  # formats of files
FITS = (FIT, LOOP)  # formats that hold a fit
CELL = ("deltaT", "k_bs_c")  # from the back of a module to its cells
#: coefficients that pvlib's PVsyst model takes from ``module_parameters``
OF_MODULE = ("module_efficiency", "alpha_absorption")
SMOOTHING = ("ewm", "steady")  # dynamics of a callable model
WEATHER = ("poa_global", "temp_air", "wind_speed")
#: values that pvlib fills in without a warning if weather has no such column
FILLED = {"wind_speed": (0.0, "m/s"), "temp_air": (20.0, "°C")}


@dataclass(frozen=True, eq=False, init=False)
class DynamicCellTemperature:
    """
    Temperature model to pass to ``ModelChain(temperature_model=...)``.

    It can be pickled, so it works in parallel runs.

    Parameters
    ----------
    model : str or callable, default "wm1"
        Steady model, as in :func:`pvlib_fem.fem_temperature`.
    dynamics : str, default "ewm"
        ``"ewm"`` or ``"steady"`` (which is ``"ewm"`` with a tau near 0),
        or ``"balance"`` for :func:`pvlib_fem.heat_balance`, which takes no callable.
    coefficients : dict, optional
        Coefficients of the model with ``tau`` or ``capacity`` and ``bias``. Without
        them each array's ``temperature_model_parameters`` are used, which may also
        have ``deltaT``, its ``irrad_ref`` and ``k_bs_c``. As in pvlib's chain, they
        have to name ``u0`` and ``u1``, or ``u_c`` and ``u_v``. If they have no
        ``module_efficiency`` or ``alpha_absorption``, those of the array's
        ``module_parameters`` are used, as in pvlib.
    deltaT : float, default 0
        Cell minus back temperature at 1000 W/m², proportional to the present
        irradiance, as in :func:`pvlib.temperature.sapm_cell`. [K]
    k_bs_c : float, default 0
        Back-to-cell resistance, instead of ``deltaT``, on irradiance smoothed with
        the time constant of the model without effects [1]_: ``tau``, or ``capacity``
        times the model's resistance at each wind. [K m²/W]
    effects : str, dict, Effect or sequence of them, optional
        Physical effects whose coefficients are among ``coefficients``. If they need
        the solar position and the plane of the module, the chain provides them.
    base : dict, optional
        Coefficients of the model without effects, for effects that grow with the
        module's temperature; by default taken from ``coefficients``.
    **drivers
        Series by name, aligned on time with the run: ``poa_global``,
        ``temp_air`` or ``wind_speed`` instead of the chain's, drivers of the
        effects, or further arguments of a callable model, such as ``ir_down``.

    Notes
    -----
    pvlib infers a *static* model from keys such as ``u0`` and ``u1`` in an
    array's ``temperature_model_parameters`` when no ``temperature_model`` is
    given.

    Coefficients hold for wind at the height of the anemometer to which they were
    fitted. Most weather files have the wind at 10 m; give ``wind_speed =
    weather["wind_speed"] * (height / 10)**(1 / 7)``.

    In pvlib's chain the efficiency of ``"noct_sam"`` follows the effective irradiance;
    here it is constant. So even a steady run differs from pvlib's, by some tenths of
    a kelvin.

    References
    ----------
    .. [1] B. Herteleer et al., "Investigating methods to improve photovoltaic
       thermal models at second-to-minute timescales", 2022, Eq. 35.
       :doi:`10.22541/au.166922866.68736478`
    """

    model: object
    dynamics: str
    coefficients: dict | None
    deltaT: float
    k_bs_c: float
    effects: tuple
    base: dict | None
    drivers: dict = field(repr=False)

    def __init__(
        self,
        model: str | Callable[..., Any] = "wm1",
        dynamics: str = "ewm",
        coefficients: Mapping[str, float] | None = None,
        deltaT: float = 0.0,
        k_bs_c: float = 0.0,
        effects: EffectLike | Iterable[EffectLike] = (),
        base: Mapping[str, float] | None = None,
        **drivers: pd.Series,
    ) -> None:
        if callable(model):
            refuse_dynamic(model)
        if callable(model) and dynamics not in SMOOTHING:
            raise ValueError(
                f"dynamics = {dynamics!r} needs a steady model by name; a callable "
                f"takes {' or '.join(SMOOTHING)}"
            )
        for name, series in drivers.items():
            if not isinstance(getattr(series, "index", None), pd.DatetimeIndex):
                raise ValueError(f"driver {name} must be a Series with a DatetimeIndex")
        if not callable(model):
            model = steady_model(model, dict(coefficients or {})).name
            wanted = thermal_model(model, dynamics, map(find, several(effects)))
            effects = wanted.effects
            if coefficients is not None:
                refuse_cell(coefficients)
                wanted.checked(coefficients)
            given = [n for n in drivers if n not in WEATHER]
            # the chain provides the solar position and the plane of its mounts
            known = [n for n in GEOMETRY if n in wanted.drivers and n not in given]
            wanted.check_drivers([*given, *known])
        elif effects:
            raise ValueError(
                "a callable model takes no effects; give a steady model's name"
            )
        values = dict(
            model=model,
            dynamics=dynamics,
            coefficients=None if coefficients is None else dict(coefficients),
            deltaT=deltaT,
            k_bs_c=k_bs_c,
            # effects of the model; () for a callable
            effects=tuple(effects),  # type: ignore[arg-type]
            base=None if base is None else dict(base),
            drivers=drivers,
        )
        for name, value in values.items():
            object.__setattr__(self, name, value)

    @classmethod
    def from_json(cls, path: FilePath, **options: Any) -> Self:
        """
        The model of a fit or a loop that ``to_json`` or ``pvlib-fem`` wrote.

        Parameters
        ----------
        path : str or path-like
        **options
            ``deltaT``, ``k_bs_c``, by default from the file; drivers; and
            ``effects``: your own effects in the fit, of which the file has only name
            and settings.

        Raises
        ------
        ValueError
            If the file is of another kind or version, or a coefficient is missing or
            no number; the message names it.
        """
        with opened(path, FITS) as stored:
            fit = fit_in(stored)
            model, coefficients = model_of(fit, options.pop("effects", ()))
            if not {"deltaT", "k_bs_c"} & {*options}:
                options |= fit.read("cell", dict[str, float])
        options.setdefault("base", model.base)
        return cls(
            model.steady_model.name,
            model.dynamics,
            coefficients,
            effects=model.effects,
            **options,
        )

    def __call__(self, mc: Any) -> None:
        """Assign ``mc.results.cell_temperature``, as ModelChain expects."""
        poa = irradiance(mc.results)
        weather = mc.results.weather
        one_for_all = not isinstance(weather, tuple)
        cells = []
        for i, (array, poa_global) in enumerate(zip(mc.system.arrays, poa)):
            frame = weather if one_for_all else weather[i]
            if i == 0 or not one_for_all:
                self.warn_of_filled(frame)
            place = self.geometry(mc, array, poa_global.index)
            cells.append(self.cell_temperature(poa_global, frame, array, place))
        several = isinstance(mc.results.effective_irradiance, tuple)
        mc.results.cell_temperature = tuple(cells) if several else cells[0]

    def geometry(self, mc: Any, array: Any, index: pd.DatetimeIndex) -> dict:
        """Solar position and plane of the array that effects need and no driver has."""
        if callable(self.model):
            return {}
        needed = self.thermal.drivers
        missing = [n for n in GEOMETRY if n in needed and n not in self.drivers]
        if not missing:
            return {}
        position = mc.results.solar_position
        if position is not None and position.index.equals(index):
            place = position[["zenith", "azimuth"]].add_prefix("solar_")
            apparent = position["apparent_zenith"]
        else:  # after run_model_from_effective_irradiance it is missing or outdated
            place = sun(index, mc.location)
            apparent = sun(index, mc.location, refraction=True)["solar_zenith"]
        mounted = array.mount.get_orientation(apparent, place["solar_azimuth"])
        for name in ("surface_tilt", "surface_azimuth"):
            # at night a tracker's orientation is NaN, and it has no influence
            place[name] = pd.Series(mounted[name], index).fillna(0.0)
        return {name: place[name] for name in missing}

    def cell_temperature(
        self, poa_global: pd.Series, weather: pd.DataFrame, array: Any, place: dict
    ) -> pd.Series:
        """Cell temperature of one array. [°C]"""
        index = poa_global.index
        own = {
            name: driver_at_times(name, s, index) for name, s in self.drivers.items()
        }
        own |= place
        poa_global = own.pop("poa_global", poa_global)
        temp_air = own.pop("temp_air", weather["temp_air"])
        wind_speed = own.pop("wind_speed", weather["wind_speed"])
        coefficients = dict(self.coefficients or {})
        delta, k_bs_c, reference = self.deltaT, self.k_bs_c, 1000.0
        if self.coefficients is None:
            coefficients = self.coefficients_of(array)
            if not callable(self.model):
                delta = coefficients.pop("deltaT", delta)
                reference = coefficients.pop("irrad_ref", reference)
            k_bs_c = coefficients.pop("k_bs_c", k_bs_c)
        if callable(self.model):
            usual = INSTANT if self.dynamics == "steady" else TAU
            tau = coefficients.setdefault("tau", usual)
            if self.dynamics == "steady":
                refuse_tau(tau)
            temperature: Any = fem_temperature(
                poa_global,
                temp_air,
                wind_speed,
                model=self.model,
                **coefficients,
                **own,
            )
        else:
            named: Any = self.model
            steady = steady_model(named, coefficients)
            thermal = replace(self.thermal, steady_model=steady)
            if missing := thermal.missing(coefficients):
                raise ValueError(missing_in_array(thermal, missing, array))
            temperature = thermal.predict(
                poa_global, temp_air, wind_speed, coefficients, **own
            )
            there = wind_speed.where(temperature.notna())
            tau = thermal.time_constant(coefficients, there)
        if delta and k_bs_c:
            raise ValueError(
                f"deltaT = {delta:g} K and k_bs_c = {k_bs_c:g} K m²/W both lead from "
                "the back of the module to its cells; give one of them"
            )
        if delta:
            temperature = temperature + poa_global / reference * delta
        if k_bs_c:
            taus: Any = pd.Series(tau, index)
            smoothed = ewm(poa_global.where(taus > 0), taus.fillna(TAU))
            temperature = temperature + k_bs_c * smoothed
        return temperature

    def coefficients_of(self, array: Any) -> dict:
        """Parameters of an array's temperature model, completed by its module's."""
        own, module = array.temperature_model_parameters, array.module_parameters
        if callable(self.model):
            known = arguments_of(self.model)
        else:
            known = self.thermal.steady_model.coefficients
        with_it = {n: module[n] for n in OF_MODULE if n in known and n in module}
        return with_it | dict(own)

    @property
    def thermal(self) -> ThermalModel:
        """The thermal model with its effects."""
        name: Any = self.model
        return thermal_model(name, self.dynamics, self.effects, self.base)

    def warn_of_filled(self, weather: pd.DataFrame) -> None:
        calm = not callable(self.model) and "wind_speed" not in self.thermal.usual
        for name, (value, unit) in FILLED.items():
            if calm and name == "wind_speed":
                continue
            if name not in self.drivers and np.all(weather[name] == value):
                warnings.warn(
                    f"{name} is {value:g} {unit} throughout, which pvlib fills in "
                    "if weather has no such column: the cell temperature is wrong "
                    f"unless that is true; add {name} to weather, or pass it as "
                    f"temperature_model({name}=...)",
                    stacklevel=2,
                )


def refuse_cell(coefficients: Mapping[str, float]) -> None:
    """Refuse the way from the back to the cells among a model's coefficients."""
    if found := [name for name in CELL if name in coefficients]:
        raise ValueError(
            f"{found[0]} is no coefficient of the model: it leads from the back of the "
            f"module to its cells; give it as {found[0]}={coefficients[found[0]]} "
            "in addition to coefficients"
        )


def missing_in_array(thermal: ThermalModel, missing: list[str], array: Any) -> str:
    """Message about coefficients that the parameters of an array do not have."""
    steady = thermal.steady_model
    usual = {n: f" (in pvlib {value:g})" for n, value in steady.defaults.items()}
    name = f" {array.name}" if array.name else ""
    return (
        f"{steady.name} needs {', '.join(n + usual.get(n, '') for n in missing)}, and "
        f"temperature_model_parameters of the array{name} hold "
        f"{', '.join(array.temperature_model_parameters) or 'nothing'}; add them "
        "there, or give coefficients to DynamicCellTemperature"
    )


def arguments_of(model: Any) -> Collection[str]:
    """Names of the arguments of a callable; none of a compiled function."""
    try:
        return [*inspect.signature(model).parameters]
    except (TypeError, ValueError):
        return []


def fit_in(stored: Stored) -> Stored:
    """
    The fit in a file of a fit or a loop.

    Parameters
    ----------
    stored : Stored
        The whole file.

    Returns
    -------
    Stored
        The file itself, or its part with the fit.

    Raises
    ------
    ValueError
        If ``cell`` has other names than ``deltaT`` and ``k_bs_c``.
    """
    fit = stored.part("fit") if stored["format"] == LOOP else stored
    if unknown := {*fit.read("cell", dict[str, float])} - {*CELL}:
        raise ValueError(
            f"{stored.file}: {fit.place}cell.{min(unknown)} is none of "
            f"{', '.join(CELL)}"
        )
    return fit


def irradiance(results: Any) -> list:
    """Plane-of-array irradiance of each array, or effective irradiance without it."""
    total, effective = results.total_irrad, results.effective_irradiance
    if not isinstance(effective, tuple):
        total, effective = (total,), (effective,)
    elif not isinstance(total, tuple):
        total = (total,) * len(effective)
    return [
        frame["poa_global"] if frame is not None and "poa_global" in frame else fallback
        for frame, fallback in zip(total, effective)
    ]


def driver_at_times(name: Any, series: Any, index: Any) -> Any:
    """The rows of a driver at the times of the run."""
    if (series.index.tz is None) != (index.tz is None):
        raise ValueError(
            f"driver {name} has times in zone {series.index.tz}, the run in "
            f"{index.tz}; give both a zone or neither"
        )
    if series.index.has_duplicates:
        at = series.index[series.index.duplicated()][0]
        raise ValueError(f"driver {name} has the time {at} twice; keep one")
    missing = index.difference(series.index)
    if len(missing):
        raise ValueError(
            f"driver {name} misses {len(missing):,} of {len(index):,} times of the "
            f"run, first {missing[0]}; give the column of the run, as "
            f"temperature_model({name}=weather['{name}']), which may hold NaN"
        )
    return series.reindex(index)
