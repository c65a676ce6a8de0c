"""The pictures of a closed loop's page, each with what it shows."""

from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING

import pandas as pd

from pvlib_fem import plotting
from pvlib_fem._record.column_names import DAYLIGHT
from pvlib_fem._record.file_summary import present
from pvlib_fem._report.rows import Draw
from pvlib_fem.plotting._residuals import by_hour_and_month, by_sector, largest_mean
from pvlib_fem.plotting._time_series import Span
from pvlib_fem.plotting._vector import svg

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from pvlib_fem._ceiling.ceiling_result import Ceiling
    from pvlib_fem._fitting.fem_fit import FemFit
    from pvlib_fem._loop.results.loop_result import Loop

LONG = 120  # days of a record from which its months are drawn
#: of the map by month and hour: its means, its picture, what it shows
MAP = (
    by_hour_and_month,
    plotting.plot_residual_map,
    "mean residual by month of each year and hour, all days (–: below zero)",
)


def pictures(loop: "Loop") -> list[tuple[str, str]]:
    """
    Figures of a page, each with what it shows.

    Parameters
    ----------
    loop : Loop

    Returns
    -------
    list of (str, str)
        An ``svg`` element, and its caption.
    """
    which = "test" if loop.fit.test_days else "fitted"
    # rows of a stuck sensor have no residual
    residual = present(loop.fit.residual)
    known = residual.notna()
    before, after = present(loop.residual_before)[known], residual[known]
    changed = loop.last != loop.base
    day = Span(loop.fit).date
    drawn = [
        draw(
            "steps",
            lambda ax: plotting.plot_steps(loop, ax),
            f"RMSE on the {which} days, step by step",
        ),
        draw(
            "budget",
            lambda ax: plotting.plot_budget(loop, ax),
            "Mean square error of the steady model: the part that each step removes, "
            "and the remaining error by time scale",
            size=(4.8, 0.7 + 0.27 * len(loop.budget)),
        ),
        draw(
            "day",
            lambda ax: plotting.plot_before_after(loop, ax),
            f"The most variable of the {which} days, {day}",
        ),
    ]
    last = {"After": after} if changed else {"": after}
    both = {"Before": before, **last} if changed else last
    drawn += on_one_scale("map", both, *MAP)
    if loop.fit.effects:
        words = (
            "Contribution of each effect to the temperature on that day, given all "
            "others; rms over all days"
        )
        drawn.append(
            draw(
                "parts",
                lambda ax: plotting.plot_contributions(loop, ax),
                words,
                size=(4.2, 2.7 + 0.2 * len(loop.fit.effects)),
            )
        )
    drawn += by_month(loop.fit)
    return [*drawn, *by_wind(loop.fit, both, last, known)]


def picture_of_ceiling(ceiling: "Ceiling") -> tuple[str, str]:
    """
    The bar of a ceiling, and what it shows.

    Parameters
    ----------
    ceiling : Ceiling
        Errors of the paper's form, the loop and the trees on the test weeks.

    Returns
    -------
    (str, str)
        An ``svg`` element, and its caption.
    """
    words = (
        "Mean square of the paper's form: the part that the loop explains, the part "
        "that only boosted trees on the same columns explain, and the rest"
    )
    size = (4.8, 1.8)

    def bar(ax: "Axes") -> None:
        plotting.plot_ceiling(ceiling, ax)

    return draw("ceiling", bar, words, size=size)


def pictures_of_fit(fit: "FemFit") -> list[tuple[str, str]]:
    """
    Figures of a fit's page, each with what it shows.

    Parameters
    ----------
    fit : FemFit

    Returns
    -------
    list of (str, str)
        An ``svg`` element, and its caption.
    """
    residual = present(fit.residual)
    known = residual.notna()
    remaining = {"": residual[known]}
    which = "held-out" if fit.test_days else "fitted"
    words = f"The most variable of the {which} days, {Span(fit).date}"
    return [
        # two panels, whose axis titles need room
        draw("day", lambda ax: plotting.plot_fit(fit, ax), words, size=(4.2, 4.0)),
        *by_month(fit),
        *on_one_scale("map", remaining, *MAP),
        *by_wind(fit, remaining, remaining, known),
    ]


def by_month(fit: "FemFit") -> Iterator[tuple[str, str]]:
    """Coefficients through time, of a record that is long enough to show a change."""
    record = fit.summary
    if fit.daily is None or record.end - record.start <= pd.Timedelta(days=LONG):
        return
    try:
        table = fit.through_time()
    except ValueError:  # all of the model's are held or at a bound
        return
    given = [effect.settings for effect in fit.effects if effect.sensor_fault]
    names = ("at", "start", "end")
    dates = [dates[name] for dates in given for name in names if name in dates]
    words = (
        "Monthly coefficients, from fitted days, with 95 % intervals; the "
        "line is the whole fit, r_eq the over-temperature per irradiance at the mean "
        "wind"
    )
    height = 0.6 + 0.9 * len(table.index.unique("coefficient"))
    yield draw(
        "months",
        lambda ax: plotting.plot_through_time(fit, ax, dates),
        words,
        size=(4.8, height),
    )


def by_wind(
    fit: "FemFit",
    both: Mapping[str, pd.Series],
    last: Mapping[str, pd.Series],
    known: pd.Series,
) -> Iterator[tuple[str, str]]:
    """Residual by irradiance and wind, and a rose where its direction is known."""
    (after,) = last.values()
    changed, record = "After" in last, present(fit.record)
    columns = {
        name: pd.Series(record[name], record.index, name=name)[known]
        for name in ("poa_global", "wind_speed", "wind_direction")
        if name in record.inputs.columns
    }
    if "wind_speed" in record.absent:
        return
    sunny = columns["poa_global"] > DAYLIGHT
    by = (after[sunny], columns["poa_global"][sunny], columns["wind_speed"][sunny])
    if sunny.any():
        words = "mean residual by irradiance and wind, by day (–: below zero)"
        words = f"After: {words}" if changed else words.capitalize()
        yield draw("wind", lambda ax: plotting.plot_residual_by(*by, ax=ax), words)
    names = [effect.name for effect in fit.effects]
    if "wind_direction" in columns:
        wind = columns["wind_speed"], columns["wind_direction"]
        yield from on_one_scale(
            "rose",
            both if "wind_direction" in names else last,
            lambda residual: by_sector(residual, *wind)[0],
            lambda residual, *how: plotting.plot_residual_rose(residual, *wind, *how),
            "mean residual by wind direction and wind speed (–: below zero)",
            "polar",
        )


def draw(
    name: str,
    picture: Draw,
    words: str,
    projection: str | None = None,
    **size: tuple[float, float],
) -> tuple[str, str]:
    """
    A picture and what it shows.

    Parameters
    ----------
    name : str
        Prefix of the identifiers in the picture, unique within a page.
    picture : callable
        Function that draws on axes.
    words : str
        What the picture shows.
    projection : str, optional
    **size : (float, float)
        ``size``, width and height. [inch]

    Returns
    -------
    (str, str)
        An ``svg`` element, and ``words``.
    """
    return svg(picture, name, projection=projection, **size), words


def on_one_scale(
    kind: str,
    residuals: Mapping[str, pd.Series],
    means: Callable[[pd.Series], pd.DataFrame],
    plot: Callable[..., object],
    words: str,
    projection: str | None = None,
) -> Iterator[tuple[str, str]]:
    """One picture of each residual, with the scale of the largest of them."""
    limit = largest_mean(*map(means, residuals.values()))
    for name, residual in residuals.items():

        def picture(ax: "Axes", residual: pd.Series = residual) -> None:
            plot(residual, ax, limit)

        caption = f"{name}: {words}" if name else words.capitalize()
        if name and len(residuals) > 1:
            caption += ", on one scale"
        yield draw(f"{kind}{name}", picture, caption, projection)
