"""
What a dynamic cell temperature changes in the energy of a year
===============================================================

A ModelChain runs a made-up year at 1 min twice: with the steady Faiman model, as
pvlib has it, and with the heat balance of the same coefficients. The steady
temperature is highest in the very minute in which the sun breaks through, so it
takes too much energy from the brightest minutes; what it gives back in the
minutes after does not make up for it.
"""

from pvlib.location import Location
from pvlib.modelchain import ModelChain
from pvlib.pvsystem import Array, FixedMount, PVSystem

import pvlib_fem as fem

FAIMAN = dict(u0=25.0, u1=6.84)
CAPACITY = 15e3  # J/(m² K)


def run(weather, temperature_model):
    """A 1 kWp plant on a fixed rack with a small inverter."""
    array = Array(
        FixedMount(surface_tilt=35, surface_azimuth=180),
        module_parameters={"pdc0": 1000.0, "gamma_pdc": -0.0035},
    )
    chain = ModelChain(
        PVSystem([array], inverter_parameters={"pdc0": 950.0}),
        Location(35, -106),
        aoi_model="physical",
        spectral_model="no_loss",
        dc_model="pvwatts",
        ac_model="pvwatts",
        temperature_model=temperature_model,
    )
    return chain.run_model(weather).results


def compare(days=365):
    """Energies and temperature errors of both runs."""
    weather = fem.datasets.synthetic(days, 60, start="2023-01-01", noise=0)
    weather = weather.drop(columns=["poa_global", "temp_module"])
    steady = run(
        weather,
        fem.DynamicCellTemperature("faiman", "steady", FAIMAN),
    )
    dynamic = run(
        weather,
        fem.DynamicCellTemperature(
            "faiman", "balance", {**FAIMAN, "capacity": CAPACITY}
        ),
    )
    poa = dynamic.total_irrad["poa_global"]
    day = poa > 20
    temperatures = dynamic.cell_temperature[day], steady.cell_temperature[day]
    error = fem.scores.energy_error(
        poa, dynamic.cell_temperature, steady.cell_temperature
    )
    hours = 1 / 60
    return {
        "insolation [kWh/m²]": poa.sum() * hours / 1000,
        "AC energy, steady [kWh/kWp]": steady.ac.sum() * hours / 1000,
        "AC energy, dynamic [kWh/kWp]": dynamic.ac.sum() * hours / 1000,
        "over-estimate by the steady model [kWh/kWp]": error.over_estimate,
        "under-estimate by the steady model [kWh/kWp]": error.under_estimate,
        "both, without signs [kWh/kWp]": error.total,
        "PR error without signs [points]": error.performance_ratio,
        "RMSE of the steady temperature, by day [K]": fem.scores.rmse(*temperatures),
        "largest minute of DC power that differs [W/kWp]": (dynamic.dc - steady.dc)
        .abs()
        .max(),
    }


if __name__ == "__main__":
    for name, value in compare().items():
        print(f"{name:<50}{value:>10.2f}")
