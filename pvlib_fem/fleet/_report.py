"""An HTML page on many systems."""

import os
from collections.abc import Sequence
from pathlib import Path
from urllib.parse import quote

import numpy as np
import pandas as pd

from pvlib_fem._record.names import unmapped
from pvlib_fem._report.document import (
    Block,
    Link,
    Paragraph,
    Parts,
    Table,
    document,
    listed,
    section,
    table,
)
from pvlib_fem._report.formatting import two_decimals, two_digits
from pvlib_fem._report.page_parts import heading
from pvlib_fem._stored import saved
from pvlib_fem._thermal.steady_models import STEADY_MODELS
from pvlib_fem.fleet._results import Results
from pvlib_fem.fleet._shared import Shared, few_names, shared_causes
from pvlib_fem.fleet._store import page_path, put_page
from pvlib_fem.fleet._system_work import title_of
from pvlib_fem.fleet._tasks import CLOCK, SENSOR, TASKS
from pvlib_fem.types import FilePath

SHOWN = 50  # rows of each table of the page
OF_COLUMN = "driver:"  # before the column of the user's own that an effect is of
#: coefficients of all models without their effects
OWN = {name for one in STEADY_MODELS.values() for name in one.parameters}
OWN |= {"tau", "capacity", "bias"}


def report(
    out: FilePath,
    path: FilePath | None = None,
    by: str = "mounting",
    title: str = "",
) -> str:
    """
    One page on a folder of results, with links to the systems' own pages.

    The page lists systems with clock or location faults; failures with their reasons,
    such as wrong units; the systems with the largest energy errors; the findings by
    effect and by site; and the spread of coefficients.

    Parameters
    ----------
    out : path
        Folder of the results of :func:`pvlib_fem.fleet.run`.
    path : path, optional
        File to write; by default none, and links are relative to the folder ``out``.
    by : str, default "mounting"
        Label of the table by which coefficients are grouped.
    title : str, optional

    Returns
    -------
    str

    Raises
    ------
    ValueError
        If the folder holds no results.
    """
    results = Results(Path(out).absolute())
    systems, findings = results.systems, results.findings
    folder = results.out if path is None else Path(path).absolute().parent
    pages = Pages(results, folder)
    words = headline(systems)
    parts: Parts = [
        heading(words, title),
        section("Clock, location and sensor faults", device_faults(findings, pages)),
        section("What failed", failures(systems)),
        section("Systems to visit first", to_visit(systems, pages)),
        section(
            "What was found", unnamed_columns(findings), by_effect(systems, findings)
        ),
        section("What systems of a site share", by_site(systems, findings, pages)),
        section(
            f"Coefficients by {by}",
            coefficient_table(systems, results.coefficients, by),
        ),
    ]
    return saved(document(" · ".join(filter(None, [title, words])), parts), path)


class Pages:
    """Links to the pages of systems; missing pages are written."""

    def __init__(self, results: Results, folder: Path) -> None:
        self.results, self.folder = results, folder
        rows = results.systems.set_index("id")
        self.sites = rows["site"].where(rows["state"] == "done")
        self.paged = all(TASKS[name].paged for name in rows["task"].unique())

    def __getitem__(self, identity: str) -> str | Link:
        if not self.paged:
            return identity
        path = page_path(self.results.out, identity)
        if not path.exists():
            title = title_of(identity, self.sites[identity])
            html = self.results.result(identity).to_html(title=title)
            put_page(self.results.out, identity, html)
        try:
            address = quote(Path(os.path.relpath(path, self.folder)).as_posix())
        except ValueError:  # on another drive
            address = path.as_uri()
        return Link(identity, address)


def headline(systems: pd.DataFrame) -> str:
    """Number of systems by state, and their median error."""
    done = systems[systems["state"] == "done"]
    words = f"{len(systems):,} systems, {len(done):,} done"
    if lost := int((systems["state"] == "failed").sum()):
        words += f", {lost:,} failed"
    if waiting := int((systems["state"] == "not run").sum()):
        words += f", {waiting:,} not run"
    if done["rmse_after"].notna().any():  # a recovery has no error
        before, after = map(two_decimals, done[["rmse_before", "rmse_after"]].median())
        words += f"; median error {before} K before, {after} K after"
    return words


def to_visit(systems: pd.DataFrame, pages: Pages) -> Table:
    """Table of systems, with the largest energy error per year first."""
    done = systems[systems["state"] == "done"]
    share = done["energy_error_before"].fillna(done["energy_error_after"])
    lost = share / 100.0 * done["insolation"]
    known = bool(len(done)) and bool(done["pdc0"].notna().all())
    loss = lost * done["pdc0"] / 1000.0 if known else lost
    rows = done.assign(share=share, lost=loss)
    rows = rows.sort_values(["lost", "id"], ascending=[False, True])
    lines = [
        (
            pages[row["id"]],
            row["site"],
            energy_text(row["lost"], known),
            two_decimals(row["share"]),
            two_decimals(row["energy_error_after"]),
            two_decimals(row["rmse_before"]),
            two_decimals(row["rmse_after"]),
            row["effects"],
        )
        for row in rows.head(SHOWN).to_dict("records")
    ]
    unit = "kWh a year" if known else "kWh/kWp a year"
    head = ("system", "site", f"#energy error [{unit}]", "#before [% of yield]")
    head += ("#after [% of yield]",)
    return shortened_table(
        (*head, "#RMSE before [K]", "#RMSE after [K]", "found"),
        lines,
        len(rows),
        "Absolute energy error that temperature errors of the model without effects "
        "cause, on held-out days, at the insolation of the record; after is the error "
        "of the model with all findings.",
    )


def energy_text(energy: float, whole: bool) -> str:
    """An energy of a plant, or of a kWp; a dash without test days."""
    if not np.isfinite(energy):
        return two_decimals(energy)
    return f"{energy:,.0f}" if whole else f"{energy:.1f}"


def device_faults(findings: pd.DataFrame, pages: Pages) -> Paragraph | Table:
    """Table of systems with wrong times, a wrong location or a detached sensor."""
    if findings.empty:
        return Paragraph("None was found.")
    faults = findings[findings["kind"].isin([CLOCK, SENSOR])]
    if faults.empty:
        return Paragraph("None was found.")
    # uncorrected faults first
    faults = faults.assign(treated=faults["verdict"] != "not corrected")
    faults = faults.sort_values(["treated", "id"], kind="stable")
    rows = [
        (pages[row["id"]], row["site"], row["verdict"], row["why"])
        for row in faults.head(SHOWN).to_dict("records")
    ]
    head = ("system", "site", "state", "fault and remedy")
    words = (
        "A fault that is not corrected can falsify all other findings of its system."
    )
    return shortened_table(head, rows, len(faults), words, wraps=True)


def unnamed_columns(findings: pd.DataFrame) -> list[Paragraph]:
    """Causes that may be columns which the table of systems does not name."""
    if findings.empty:
        return []
    causes = findings[findings["effect"].str.startswith(OF_COLUMN)]
    columns = causes["effect"].str.removeprefix(OF_COLUMN)
    systems = dict(iter(causes["id"].groupby(columns)))
    likely = unmapped(systems)
    if not likely:
        return []
    some = "; ".join(
        f"{column} (in {few_names(systems[column].unique())}) as {name}"
        for column, name in likely.items()
    )
    return [
        Paragraph(
            "A column without a known name may be taken for a cause that it is not. "
            f"These may have one, to be given in the table of systems: {some}."
        )
    ]


def by_effect(systems: pd.DataFrame, findings: pd.DataFrame) -> Paragraph | Table:
    """Table of the findings by effect: number of systems, sites and gains."""
    if findings.empty:
        return Paragraph("No effect was tested, or none was found.")
    done = max(int((systems["state"] == "done").sum()), 1)
    groups = findings.groupby(["effect", "verdict"], sort=True)
    rows = []
    for (effect, verdict), some in groups:
        count, gain = some["id"].nunique(), some["gain"]
        sites = [site for site in some["site"].unique() if site]
        rows.append(
            (
                -count,
                (
                    effect,
                    verdict,
                    f"{count:,}",
                    f"{100.0 * count / done:.0f}",
                    f"{len(sites):,}",
                    two_decimals(gain.median()),
                    two_decimals(gain.max()),
                    few_names(sites),
                ),
            )
        )
    rows.sort(key=lambda row: row[0])
    head = ("effect", "verdict", "#systems", "#share [%]", "#sites")
    head += ("#median gain [K]", "#largest gain [K]")
    return shortened_table((*head, "where"), [row for _, row in rows], len(rows))


def by_site(
    systems: pd.DataFrame, findings: pd.DataFrame, pages: Pages
) -> Paragraph | Table:
    """Table of causes that systems of a site share, or that one has alone."""
    groups = shared_causes(systems, findings) if len(findings) else []
    if not groups:
        return Paragraph(
            "No site has several systems with findings. Systems with the same value in "
            "the column site of the table of systems share a weather station."
        )
    lines = [
        (
            group.site,
            few_names(group.candidates, " or ", " or "),
            group.words,
            dates_of_group(group),
            two_decimals(float(np.median([*group.systems.values()]))),
            pages[min(group.systems, key=lambda one: (-group.systems[one], one))],
        )
        for group in groups[:SHOWN]
    ]
    head = ("site", "cause", "in how many", "when", "#median gain [K]", "clearest in")
    return shortened_table(
        head,
        lines,
        len(groups),
        "For systems that share a weather station: a cause that all have at one time "
        "is in the station, or acts on all of them; a cause of one system alone is at "
        "its module.",
        wraps=True,
    )


def dates_of_group(group: Shared) -> str:
    if group.first is None:
        return ""
    same = group.first == group.last
    return group.first if same else f"{group.first} to {group.last}"


def coefficient_table(
    systems: pd.DataFrame, values: pd.DataFrame, by: str
) -> Paragraph | Table:
    """Table of the spread of each coefficient, by a label and the model."""
    labels = systems.set_index("id")
    which = labels[by] if by in labels else pd.Series("", labels.index)
    own = values[values["coefficient"].isin(OWN)]
    own = own.assign(by=own["id"].map(which), model=own["id"].map(labels["model"]))
    lines = []
    groups = own.groupby(["by", "model", "coefficient"], sort=True)
    for (label, model, name), some in groups:
        low, middle, high = some["value"].quantile([0.1, 0.5, 0.9])
        error = some["stderr"].median()
        cells = (*map(four_digits, (low, middle, high)), two_digits(error))
        count = f"{len(some):,}"
        unit = some["unit"].iloc[0]
        lines.append((label or "not given", model, name, unit, count, *cells))
    if not lines:
        return Paragraph("The results have no coefficients of a model.")
    head = (by, "model", "coefficient", "unit", "#systems", "#10 %", "#median", "#90 %")
    words = "" if by in labels else f" The table of systems has no column {by}."
    return shortened_table(
        (*head, "#median ±"),
        lines,
        len(lines),
        "Quantiles over the systems; the last column is the median standard error of "
        "one coefficient." + words,
    )


def four_digits(value: float) -> str:
    """Four digits, without an exponent."""
    return f"{value:,.0f}" if abs(value) >= 1e4 else f"{value:.4g}"


def failures(systems: pd.DataFrame) -> Block | list[Block]:
    """List of messages, with the systems that have them."""
    failed = systems[systems["state"] == "failed"]
    if failed.empty:
        return Paragraph("Nothing.")
    groups = failed.groupby("message", sort=False)["id"].apply(list)
    groups = sorted(groups.items(), key=lambda pair: (-len(pair[1]), pair[0]))
    shown = [(few_names(names), str(message)) for message, names in groups[:SHOWN]]
    more = len(groups) - len(shown)
    rest = Paragraph(f"{more:,} other messages are in systems.parquet.", "soft")
    return [listed(shown), *[rest] * (more > 0)]


def shortened_table(
    head: Sequence[str],
    rows: Sequence[Sequence[str | Link]],
    total: int,
    caption: str = "",
    wraps: bool = False,
) -> Table:
    """A table of the first rows; its caption has their total number."""
    rest = f" The first {SHOWN} of {total:,}; all are in Parquet." * (total > SHOWN)
    return table(head, rows[:SHOWN], (caption + rest).strip(), wraps)
