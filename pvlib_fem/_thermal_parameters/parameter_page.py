"""The table of thermal parameters as text and as an HTML page."""

import textwrap
from collections.abc import Iterator

import numpy as np
import pandas as pd

from pvlib_fem._report.document import (
    Block,
    Heading,
    Paragraph,
    document,
    listed,
    section,
    table as markup,
)
from pvlib_fem._report.formatting import range_text, two_decimals, with_error

#: parts of the page: beginnings of the names of their conventions, and their use
PARTS = {
    "pvlib: Faiman": (
        ("faiman",),
        "pvlib.temperature.faiman(poa_global, temp_air, wind_speed, u0, u1); IEC "
        "61853-3 takes the same two.",
    ),
    "pvlib and SAM: Sandia": (
        ("sapm",),
        "pvlib.temperature.sapm_cell(poa_global, temp_air, wind_speed, a, b, deltaT). "
        "Weather files have the wind at 10 m.",
    ),
    "pvlib: Ross": (("ross",), "pvlib.temperature.ross(poa_global, temp_air, k=k)."),
    "SAM: NOCT": (
        ("noct_sam",),
        "pvlib.temperature.noct_sam(poa_global, temp_air, wind_speed, noct, "
        "module_efficiency), and SAM's NOCT cell temperature model with an array "
        "height of one story and its usual standoff. SAM's weather has the wind at 10 "
        "m.",
    ),
    "PVsyst": (
        ("pvsyst",),
        "Detailed losses, Thermal parameter: Uc and Uv. Take those for wind at 10 m "
        "where the weather file has that wind, and those without wind where it has "
        "none. The absorptance and efficiency are those of the module in PVsyst. "
        "pvlib.temperature.pvsyst_cell takes all four.",
    ),
    "NMOT": (
        ("nmot",),
        "The module's temperature at 800 W/m², 20 °C of air and 1 m/s, as the fit has "
        "it and by the procedure of IEC 61853-2 on the record.",
    ),
    "Unit mass": (
        ("prilliman", "held-out error"),
        "pvlib.temperature.prilliman(temp_cell, wind_speed, unit_mass). PVsyst 8.1 "
        "takes the module's weight over its area: enter unit_mass times the area as "
        "the weight. From 20 kg/m² on the model is unphysical in still air, and PVsyst "
        "takes its default.",
    ),
    "Time constant": (
        ("time constant",),
        "Of the module at a wind. The first is of temperatures at the end of each step "
        "and means of the inputs, the second of means of all, which most loggers "
        "store.",
    ),
    "T98": (
        ("T98",),
        "IEC TS 63126: up to 70 °C no level is needed, Level 1 goes to 80 °C and Level "
        "2 to 90 °C.",
    ),
}
HEAD = ("convention", "parameter", "#value", "#± error", "#95 % range", "unit")
MORE = ("of", "#mismatch [K]")
COLUMNS = (
    "The largest difference from the fit's temperature, as the conditions have it."
)


def cells(row: pd.Series) -> tuple[str, str, str]:
    """Value, error and range as text."""
    value, error = row["value"], row["stderr"]
    if not np.isfinite(value):
        return "–", "–", "–"
    if not (np.isfinite(error) and error > 0.0):
        return f"{value:.4g}", "–", "–"
    size, _, margin = with_error(value, error).partition(" ± ")
    return size, margin, range_text(row["low"], row["high"])


def as_text(table: pd.DataFrame) -> str:
    """
    The table as text for a terminal, with conditions and notes below.

    Parameters
    ----------
    table : DataFrame
        Result of ``fit.thermal_parameters()``.

    Returns
    -------
    str
    """
    rows = [
        (*name, *cells(row), row["unit"], row["of"], mismatch_text(row))
        for name, row in table.iterrows()
    ]
    head = [name.removeprefix("#") for name in (*HEAD, *MORE)]
    right = [name.startswith("#") for name in (*HEAD, *MORE)]
    wide = [max(map(len, column)) for column in zip(head, *rows)]
    lines, before = [], None
    for one in [tuple(head), *rows]:
        shown = ("" if one[0] == before else one[0], *one[1:])
        before = one[0]
        lines.append(
            "  ".join(
                cell.rjust(w) if end else cell.ljust(w)
                for cell, w, end in zip(shown, wide, right)
            ).rstrip()
        )
    lines += ["", *wrapped_lines("conditions", conditions(table))]
    for name, words in notes(table):
        lines += wrapped_lines(name, words)
    return "\n".join(lines)


def wrapped_lines(name: str, words: str) -> list[str]:
    return textwrap.wrap(f"{name}: {words}", 88, subsequent_indent="  ")


def mismatch_text(row: pd.Series) -> str:
    return two_decimals(row["mismatch"]) if np.isfinite(row["mismatch"]) else ""


def conditions(table: pd.DataFrame) -> str:
    """Conditions of the first row with a mismatch, or of the first row."""
    compared = table[table["mismatch"].notna()]
    return (compared if len(compared) else table)["conditions"].iloc[0]


def notes(table: pd.DataFrame) -> Iterator:
    """Each note once, with the parameters that have it."""
    for note, rows in table[table["note"] != ""].groupby("note", sort=False):
        sharing = {}  # parameters to the conventions that have the note on these
        names = rows.index.to_frame()["parameter"]
        for convention, own in names.groupby(level="convention", sort=False):
            sharing.setdefault(", ".join(own), []).append(convention)
        yield "; ".join(f"{'; '.join(of)} ({n})" for n, of in sharing.items()), note


def page(table: pd.DataFrame, title: str = "") -> str:
    """
    The table as one self-contained HTML file.

    Parameters
    ----------
    table : DataFrame
        Result of ``fit.thermal_parameters()``.
    title : str, optional
        Title of the page.

    Returns
    -------
    str
    """
    parts: list[Block] = [Paragraph(title, "plant")] if title else []
    parts += [Heading("Thermal parameters", "h1")]
    parts += [Paragraph(f"They hold for {conditions(table)}.", "soft")]
    parts += [section(name, table_part(table, *of)) for name, of in PARTS.items()]
    return document(" · ".join(filter(None, [title, "Thermal parameters"])), parts)


def table_part(table: pd.DataFrame, begins: tuple, use: str) -> list:
    """The rows of some conventions, their definitions, and their use."""
    of = [name.startswith(begins) for name in table.index.get_level_values(0)]
    own = table[of]
    compared = bool(own["mismatch"].notna().any())
    rows = [
        (*name, *cells(row), row["unit"], row["of"], *([mismatch_text(row)] * compared))
        for name, row in own.iterrows()
    ]
    head = (*HEAD, *MORE) if compared else (*HEAD, MORE[0])
    body = [Paragraph(use), markup(head, rows, COLUMNS * bool(compared))]
    equations = own.groupby(["equation", "source"], sort=False).size().index
    body.append(listed(("Definition", f"{e} ({s})") for e, s in equations))
    other = own["conditions"][own["mismatch"].notna()].unique()
    if more := [c for c in other if c != conditions(table)]:
        body.append(listed(("Or for", words) for words in more))
    if said := [*notes(own)]:
        body.append(listed(said))
    return body
