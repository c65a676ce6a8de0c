"""Measured records with pvlib's column names."""

from typing import Any

import pandas as pd

from pvlib_fem.datasets._download import fetch
from pvlib_fem.datasets._pip_wheel import record_table

#: names of pvlib and of this package, and names in the file
BOLZANO = {
    "poa_global": "POA_pyranometer_[W/m2]",
    "temp_air": "T_ambient_[C]",
    "wind_speed": "Wind_speed_[m/s]",
    "temp_module": "BackOfModule_Temperature_[C]",
    "wind_direction": "Wind_direction",
    "power_dc": "P_mpp_[W]",
    "power_ac": "P_ac_[W]",
}
GOLDEN = {
    "poa_global": "poa_local",
    "temp_air": "ambient_temp",
    "wind_speed": "wind_speed",
    "temp_module": "module_temp",
    "poa_global_2": "poa_measured_40",
    "poa_modelled": "poa_modeled10",
    "power_ac": "ac_power",
}
TASK_13 = {
    "source": "data shared for the benchmark of performance loss rates of IEA PVPS "
    "Task 13, doi:10.17605/OSF.IO/VTR2S; hourly means in the wheel of pvcopilot 0.1.1",
    "citation": "S. Lindig et al., Progress in Photovoltaics 29, 573 (2021), "
    "doi:10.1002/pip.3397",
    "licence": "BSD-2-Clause of that package",
    "hours": "means; not stated whether named by their begin or their end",
    "missing": "NaN where the file has no value; it has no flags; all rows are kept",
}


def load(name: str) -> pd.DataFrame:
    """
    Load a measured record with pvlib's column names.

    The public file is downloaded once and kept (pooch), unless the environment
    variable ``PVLIB_FEM_DATA`` names a folder that holds it. Its hash is always
    checked. The two records of several years are read from the wheel of another
    package, pvcopilot 0.1.1, which pip downloads with its own configuration
    (17 MB). That package is neither installed nor run, and no other file of its wheel
    is read.

    Parameters
    ----------
    name : str
        ``"sandia_week"``: seven days of March 2020 at 1 min, Albuquerque.
        ``"sandia_day"``: one windy day of broken clouds at 1 min, Albuquerque,
        with wind direction, DC power of one string and sixteen sensors.
        ``"eurac_bolzano"``: eight years to January 2019, hourly, Bolzano, with
        wind direction, DC and AC power [1]_.
        ``"nrel_stf"``: eight years to January 2018, hourly by day, Golden, with
        AC power, a second plane and a modelled irradiance [1]_.

    Returns
    -------
    DataFrame
        ``poa_global`` [W/m²], ``temp_air`` [°C], ``wind_speed`` [m/s],
        ``temp_module`` [°C] and other measured columns, as float64 with NaN for
        missing values; times without a zone, as in the file. They are local standard
        time, except for Bolzano, where they follow summer time. ``power_dc`` and
        ``power_ac`` [W] are of the whole plant, whose area is not stated, so they are
        not ``p_dc_per_area``. Site, source, citation, licence and remarks on the
        columns are in ``.attrs``.

    Raises
    ------
    ValueError
        If there is no record of that name, or a file is not the pinned one.
    OSError
        If a file is not in the folder and cannot be downloaded.
    ImportError
        If pyarrow is missing, which the records of several years need
        (``pip install "pvlib_fem[parquet]"``).

    References
    ----------
    .. [1] S. Lindig et al., "International collaboration framework for the
       calculation of performance loss rates: Data quality, benchmarks, and
       trends", Progress in Photovoltaics 29, 573 (2021),
       :doi:`10.1002/pip.3397`; data: :doi:`10.17605/OSF.IO/VTR2S`.
    """
    readers = {
        "sandia_week": sandia_week,
        "sandia_day": sandia_day,
        "eurac_bolzano": eurac_bolzano,
        "nrel_stf": nrel_stf,
    }
    if name not in readers:
        raise ValueError(f"unknown record {name!r}; there are {', '.join(readers)}")
    return readers[name]()


def sandia_week() -> pd.DataFrame:
    data = pd.read_csv(fetch("sandia_week_1min.csv"), index_col=0, parse_dates=True)
    data = data.rename(columns={"temp_pv": "temp_module"})
    data.attrs = {
        "source": "A. Driesse, Sandia National Laboratories and DuraMAT, "
        "doi:10.5281/zenodo.10003736; subset of pvlib-python pull request 1878",
        "licence": "BSD-3-Clause repository",
        "surface_tilt": "not stated",
    }
    return data


def sandia_day() -> pd.DataFrame:
    met, array = (
        pd.read_csv(fetch(file), skiprows=[0, 2, 3], index_col=0, parse_dates=True)
        for file in ("MET_2015_11_11.dat", "Baseline6kW_2015_11_11.dat")
    )
    raw = met.join(array.drop(columns="RECORD"), how="inner")
    sensors = {f"temp_module_{i}": raw[f"ModTemp{i}_Avg"] for i in range(1, 17)}
    first_array = [sensors[f"temp_module_{i}"] for i in range(1, 9)]
    data = pd.DataFrame(
        {
            "poa_global": raw["POAIrrad1_Avg"],
            "temp_air": raw["Temp_C_Avg"],
            "wind_speed": raw["WS_ms_Mean"],
            "temp_module": pd.concat(first_array, axis=1).mean(axis=1),
            "wind_direction": raw["WD_deg_SMM"],
            "relative_humidity": raw["RH_pct_Avg"],
            "power_string": raw["Sys1Vdc_Avg"] * raw["Sys1Str1Idc_Avg"],
            **sensors,
        }
    )
    data.attrs = {
        "source": "Sandia National Laboratories, Regional Test Center baseline "
        "systems, 2015-11-11; examples of sandialabs/pecos",
        "licence": "revised BSD",
        "temp_module": "mean of the eight sensors of the first array",
        "relative_humidity": "doubtful: read before use",
        "power_string": "DC power of one string [W]; its module area is not stated",
    }
    return data


def eurac_bolzano() -> pd.DataFrame:
    data = with_package_names(record_table("eurac_bolzano"), BOLZANO)
    data.attrs = {
        **TASK_13,
        "site": "Eurac Research, Bolzano, Italy",
        "latitude": 46.458,
        "longitude": 11.329,
        "tz": "Europe/Rome",
        "surface_tilt": "not stated",
        "surface_azimuth": "not stated",
        "times": "as in the file, without a zone: they follow the summer time of that "
        "tz; the hour that is skipped in spring is a row without values, the hour "
        "that is repeated in autumn is one row; from 21 to 30 June 2018 irradiance and "
        "module temperature are an hour later than power",
        "wind_direction": "doubtful about north: no hour is between 348° and 29°, as "
        "when degrees are averaged as numbers",
        "power": "DC and AC power of the plant [W], whose area is not stated; NaN in "
        "the dark",
    }
    return data


def nrel_stf() -> pd.DataFrame:
    data = with_package_names(record_table("nrel_stf"), GOLDEN)
    data.attrs = {
        **TASK_13,
        "site": "National Renewable Energy Laboratory, Golden, Colorado",
        "latitude": 39.742,
        "longitude": -105.172,
        "tz": "Etc/GMT+7",
        "surface_tilt": "not stated; the modelled column is named after 10°",
        "surface_azimuth": "not stated",
        "times": "as in the file, without a zone: local standard time by the noon of "
        "poa_global; by day only",
        "poa_global_2": "another plane, named after 40°, from February 2010; its day "
        "is about 0.6 h earlier than that of poa_global",
        "poa_modelled": "modelled by the source for 10°, not measured, from February "
        "2010; its day is about 0.6 h earlier than that of poa_global",
        "wind_speed": "from February 2010",
        "power": "AC power of the plant [W], whose area is not stated; below zero in "
        "the dark",
    }
    return data


def with_package_names(raw: pd.DataFrame, names: dict) -> Any:
    """The columns of a file with the package's names."""
    data = pd.DataFrame({name: raw[column] for name, column in names.items()})
    return data.astype(float).rename_axis(None)
