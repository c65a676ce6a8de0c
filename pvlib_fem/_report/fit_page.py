"""A fit as a page of its own, and as a table in a notebook."""

from typing import TYPE_CHECKING, Any

from pvlib_fem._report.document import (
    Paragraph,
    Parts,
    Table,
    document,
    figures,
    fragment,
    section,
    table,
)
from pvlib_fem._report.formatting import two_decimals
from pvlib_fem._report.page_parts import (
    DONE,
    NO_ROWS,
    coefficients,
    done_to_data,
    heading,
    in_energy,
    made_by,
    printed_report,
)
from pvlib_fem._report.page_pictures import pictures_of_fit
from pvlib_fem._report.treatment import screened_values
from pvlib_fem.scores import GAMMA

if TYPE_CHECKING:
    from pvlib_fem._fitting.fem_fit import FemFit

STEPS = {
    "standard": "steady, fitted to all rows",
    "filter": "steady, fitted to the rows that count",
    "steady": "no memory",
    "balance": "the heat balance",
    "ewm": "with its dynamics",
    "fem": "with its bias",
}


def fit_page(fit: "FemFit", title: str = "", gamma: float = GAMMA) -> str:
    """
    The report of a fit as one HTML file, as that of a loop.

    Parameters
    ----------
    fit : FemFit
    title : str, optional
        Of the plant or the file.
    gamma : float, default -0.0035
        Temperature coefficient of power, for the errors of energy. [1/K]

    Returns
    -------
    str
    """
    record, drawn = fit.summary, fit.record is not None
    words = headline(fit)
    parts: Parts = [
        heading(f"Module temperature: {words}", title),
        Paragraph(error_conditions(fit), "soft"),
        section("Error by step", errors(fit)),
        section("Energy", in_energy(fit, {"this fit": fit.residual}, gamma)),
        section("Evidence", figures(pictures_of_fit(fit)) if drawn else NO_ROWS),
        section(DONE, done_to_data([*screened_values(record)], fit.notes)),
        section("Annex: coefficients", coefficients(fit)),
        section(
            "Annex: how to reproduce this report",
            made_by(fit, fit_call(fit)),
            printed_report(fit),
        ),
    ]
    return document(" · ".join(filter(None, [title, words])), parts)


def brief(fit: "FemFit") -> str:
    """
    The headline, the coefficients and the errors, for a notebook.

    Parameters
    ----------
    fit : FemFit
        Fit with or without its rows.

    Returns
    -------
    str
        HTML that is no whole page.
    """
    words = f"{fit.model}, {fit.dynamics}: {headline(fit)}"
    return fragment([heading(words, tag="h4"), coefficients(fit), errors(fit)])


def error_days(fit: "FemFit") -> tuple[str, str]:
    """The days of the reported errors, and the ending of their columns."""
    return ("held-out", "test") if fit.test_days else ("fitted", "train")


def headline(fit: "FemFit") -> str:
    error = fit.scores[f"rmse_{error_days(fit)[1]}"]
    if fit.dynamics == "steady":
        return f"{error.iloc[-1]:.2f} K"
    steady = error.get("filter", error.iloc[0])  # a loop's first step is steady
    return f"{steady:.2f} K steady, {error.iloc[-1]:.2f} K with this fit"


def error_conditions(fit: "FemFit") -> str:
    record = fit.summary
    days = f"{fit.train_days} day{'s' * (fit.train_days != 1)} fitted"
    return (
        f"Error (RMSE) on the {error_days(fit)[0]} days, {'day and night' * fit.night}"
        f"{'daytime' * (not fit.night)}. {record.rows:,} rows from "
        f"{record.start:%Y-%m-%d} to {record.end:%Y-%m-%d}, {days}, {fit.test_days} "
        f"held out; model {fit.model}, dynamics {fit.dynamics}, {fit.method}."
    )


def errors(fit: "FemFit") -> Table:
    """What each step bought."""
    which, end = error_days(fit)
    keys = (f"rmse_{end}", f"mae_{end}", f"mbe_{end}", "rmse_train")
    rows = [
        (str(name), *(two_decimals(row[key]) for key in keys), STEPS.get(str(name), ""))
        for name, row in fit.scores.iterrows()
    ]
    return table(
        ("step", "#RMSE", "#MAE", "#MBE", "#fitted", ""),
        rows,
        f"K on the {which} days; MBE is measured − modelled; fitted is the RMSE on the "
        "fitted days.",
    )


def fit_call(fit: "FemFit") -> str:
    """The call that made it."""
    arguments: dict[str, Any] = {
        "model": fit.model,
        "dynamics": fit.dynamics,
        "method": fit.method,
    }
    if fit.effects:
        arguments["effects"] = [effect.spec for effect in fit.effects]
    if fit.fixed:
        arguments["fixed"] = fit.fixed
    if fit.night:
        arguments["night"] = True
    inside = "".join(f"    {name}={value!r},\n" for name, value in arguments.items())
    return f"fit = pvlib_fem.fit_fem(\n    data,\n{inside})"
