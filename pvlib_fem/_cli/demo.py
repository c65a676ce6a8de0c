"""The demonstration: a measured plant, a simulated site and its truth, and a week."""

import textwrap

import click
import pandas as pd
from pvlib.location import Location

from pvlib_fem import datasets, simulator
from pvlib_fem._cli.printing import say
from pvlib_fem._cli.run_methods import loop_of_frame
from pvlib_fem._findings import Kind, Verdict
from pvlib_fem._loop.criteria import Criteria
from pvlib_fem._loop.progress import progress_line
from pvlib_fem._loop.results.loop_result import Loop
from pvlib_fem.drivers._record_site import site_of

HIDDEN = ("sky_radiation", "wind_direction", "electrical_output")
MOST_ROWS = 10_000_000  # ten years by the half minute, some GiB


def check_length(days: int, step: float) -> None:
    """
    Refuse a simulated record that is too long.

    Parameters
    ----------
    days : int
        Length of the record.
    step : float
        Time step. [s]

    Raises
    ------
    click.BadParameter
        If the record has more than ``MOST_ROWS`` rows.
    """
    if days * 86400.0 / step > MOST_ROWS:
        raise click.BadParameter(
            f"{days} days at {step:g} s are {days * 86400.0 / step:,.0f} rows; the "
            f"demonstration takes {MOST_ROWS:,} at most",
            param_hint="--days",
        )


def demo_site(days: int, step: float, seed: int) -> Loop:
    """
    Print the loop of a simulated site, and then the effects of the simulation.

    Parameters
    ----------
    days : int
        Length of the simulated record.
    step : float
        Its time step. [s]
    seed : int
        Seed of its weather and noise.

    Returns
    -------
    Loop
        Of the record without longwave irradiance and snow depth, which few sites have.
    """
    say(
        f"a simulated site, {days} days at {step / 60:g} min, with {len(HIDDEN)} "
        "effects that the loop is not told of\n"
    )
    site = simulator.RHINE
    with progress_line() as bar:
        bar.set_description_str("simulating")
        effects = simulator.PHYSICS | dict.fromkeys(HIDDEN, 1.0)
        data = simulator.record(site, effects, days, step, seed)
    # few sites have these, so the sky has to come from the humidity
    data = data.drop(columns=["longwave_down", "snow_depth"])
    place = site.latitude, site.longitude, site.surface_tilt, site.surface_azimuth
    loop = loop_of_frame(data, site=site_of(pd.DatetimeIndex(data.index), *place))
    say(f"{loop}\n\nthe truth, which the loop has not seen")
    for name in HIDDEN:
        what = simulator.SWITCHES[name].split(";")[0]
        say(f"  {name:<22}{what}: {verdict_text(name, loop)}")
    always = [name for name in simulator.PHYSICS if name not in HIDDEN]
    say(f"  {'in every module':<22}{', '.join(always)}")
    for name in loop.effects:
        if name not in effects:
            say(f"  {name:<22}is not in the simulation")
    return loop


def verdict_text(name: str, loop: Loop) -> str:
    """What a loop said of an effect that is there."""
    for finding in loop.finding_objects:
        if name in finding.candidates and finding.kind is not Kind.STRUCTURE:
            under = "" if name == finding.effect else f", under {finding.effect}"
            how = "a hint only" if finding.verdict is Verdict.HINT else "found"
            return f"{how}{under}, {finding.gain:.2f} K"
    return "not found"


def demo_years() -> None:
    """Eight measured years, or the reason why they cannot be had."""
    data = measured_record("eurac_bolzano", "the measured plant")
    if data is None:
        say("")
        return
    place = [data.attrs[name] for name in ("latitude", "longitude", "tz")]
    loop = loop_of_frame(data, site={"location": Location(*place)})
    say(
        f"a measured plant: {data.attrs['site']}, eight hourly years; "
        f"{data.attrs['source']}\n\n{loop}\n\n"
        "no log of this plant is published, so that the truth is not known; without a "
        "model the record shows\nthat from April 2012 on over-temperature per "
        "irradiance is a fifth higher, at the same power\n"
    )


def demo_week() -> None:
    """The measured week, or the reason why it cannot be had."""
    say("")
    data = measured_record("sandia_week", "the measured week")
    if data is None:
        return
    loop = loop_of_frame(data)
    days = loop.fit.train_days + loop.fit.test_days
    say(
        f"a measured week: {data.attrs['source']}\n\n{loop}\n\n"
        f"what {days} days can say: what memory and bias are worth, on days that the "
        f"fit has not seen\nwhat they cannot: the name of an effect, which takes "
        f"{Criteria().min_days} days and its driver"
    )


def measured_record(name: str, what: str) -> pd.DataFrame | None:
    """A measured record, or None after the reason why it cannot be had."""
    try:
        with progress_line() as bar:
            bar.set_description_str(f"looking for {what}")
            return datasets.load(name)
    except (OSError, ValueError, ImportError) as error:
        reason = textwrap.shorten(str(error), 500, placeholder=" …")
        say(f"{what} cannot be had ({reason})")
        return None
