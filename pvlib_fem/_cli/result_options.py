"""Options of what is made of a record, and of what is written."""

from pathlib import Path

import click

from pvlib_fem._cli.headings import (
    KNOWN,
    OUTPUT,
    PARAMETERS,
    WRITTEN,
    option_maker,
    with_options,
)

known, parameter, output = map(option_maker, (KNOWN, PARAMETERS, OUTPUT))
#: options that fit.thermal_parameters() has as arguments
ARGUMENTS = (
    "wind_height",
    "exponent",
    "surface_tilt",
    "module_efficiency",
    "absorptance",
    "deltaT",
    "with_bias",
)
recovery_options = with_options(
    known(
        "--draws",
        type=click.IntRange(1),
        default=3,
        show_default=True,
        help="Dates and signs that are drawn for each effect.",
    ),
    known("--seed", type=click.IntRange(0), default=0, show_default=True),
    known("--processes", type=click.IntRange(1), help="By default one for each core."),
    known(
        "--reliability",
        is_flag=True,
        help="Close the loop on scrambled records, too: what they have lost and is "
        "still named is false.",
    ),
    known(
        "--trials",
        type=click.IntRange(1),
        default=10,
        show_default=True,
        help="Scrambled records of each kind, for --reliability.",
    ),
)
out_option = output("--out", type=WRITTEN, help="Write the result as JSON.")
parameter_options = with_options(
    parameter(
        "--wind-height",
        type=click.FloatRange(0, 200, min_open=True),
        help="Of the anemometer, for parameters by the wind at 10 m [m].",
    ),
    parameter(
        "--exponent",
        type=click.FloatRange(0, 1),
        default=1 / 7,
        show_default="1/7",
        help="Of the power law that takes the wind to 10 m.",
    ),
    parameter(
        "--tilt",
        "surface_tilt",
        type=click.FloatRange(0, 180),
        help="Of the module, for the conditions [°].",
    ),
    parameter(
        "--efficiency",
        "module_efficiency",
        type=click.FloatRange(0, 1),
        default=0.2,
        show_default=True,
        help="Of the module, which goes with parameters of PVsyst and SAM.",
    ),
    parameter(
        "--absorptance",
        type=click.FloatRange(0, 1, min_open=True),
        default=0.9,
        show_default=True,
        help="The same, alpha of PVsyst and tau-alpha of SAM.",
    ),
    parameter(
        "--deltaT",
        "deltaT",
        type=click.FloatRange(-5, 20),
        help="From the back of the module to its cells at 1000 W/m², by default as the "
        "fit keeps it [K].",
    ),
    parameter(
        "--with-bias/--without-bias",
        default=True,
        show_default=True,
        help="Take the bias of the fit for the module's own, or for the thermometer's.",
    ),
    parameter(
        "--typical-year",
        type=click.Path(exists=True, dir_okay=False, path_type=Path),
        help="File with poa_global, temp_air and wind_speed of a year, for T98.",
    ),
    output("--csv", type=WRITTEN, help="Write the table as CSV."),
)
report_option = output(
    "--report",
    type=WRITTEN,
    help="Write the report with pictures as one HTML file (needs matplotlib).",
)
title_option = output("--title", help="Of the report; by default the name of the file.")
correction_options = with_options(
    output(
        "--details",
        is_flag=True,
        help="Print every check, hint and note instead of the summary.",
    ),
    output(
        "--corrected",
        type=WRITTEN,
        help="Write FILE as CSV without the faults of instruments that are found, "
        "under its own names; what was measured is NAME_original.",
    ),
    output(
        "--resolve",
        multiple=True,
        metavar="NAME",
        help="The cause of an ambiguous finding, such as irradiance_sensor_step, for "
        "--corrected; once for each. FINDING=NAME where two have the same causes.",
    ),
)
ceiling_option = output(
    "--ceiling",
    is_flag=True,
    help="Add how much of the error the columns of FILE could still explain, by "
    "boosted trees (needs scikit-learn; takes up to a minute).",
)
plot_option = output(
    "--plot",
    type=WRITTEN,
    help="Draw a held-out day to this file, .png, .svg or .pdf (needs matplotlib).",
)
