"""Options of many systems."""

from pathlib import Path

import click

from pvlib_fem._cli.headings import EFFECTS, OUTPUT, SYSTEMS, option_maker, with_options
from pvlib_fem._cli.model_options import effects_option, fix_option, model_option
from pvlib_fem.fleet._tasks import TASKS

system, output, effect = map(option_maker, (SYSTEMS, OUTPUT, EFFECTS))
fleet_options = with_options(
    output(
        "--out",
        required=True,
        type=click.Path(file_okay=False, path_type=Path),
        help="Folder of the results, which all workers see.",
    ),
    system(
        "--task",
        type=click.Choice(list(TASKS)),
        default="loop",
        show_default=True,
        help="What is done with each system.",
    ),
    system(
        "--scheduler",
        "client",
        metavar="ADDRESS",
        help="Of a running Dask cluster, such as tcp://10.0.0.7:8786; by default one "
        "on this machine, for as long as the command runs.",
    ),
    system(
        "--workers",
        type=click.IntRange(min=0),
        help="Processes on this machine, by default one a core; 0 works without any.",
    ),
    system(
        "--memory-limit",
        default="auto",
        show_default=True,
        help="Of each worker on this machine, such as 4GiB.",
    ),
    system(
        "--resume/--anew",
        default=True,
        show_default=True,
        help="Keep what was done of the same files in the same way.",
    ),
    output(
        "--pages", is_flag=True, help="Write each system's page with pictures, too."
    ),
    model_option("faiman", "for all systems"),
    effects_option,
    fix_option,
    effect(
        "--min-rmse-reduction",
        "--min-gain",
        type=click.FloatRange(min=0),
        help="Reduction of the RMSE below which loop adds no effect [K].",
    ),
)
