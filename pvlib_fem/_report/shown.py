"""The evidence of a loop: each finding with the pictures that show it."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import pandas as pd

from pvlib_fem._report import event_text as events
from pvlib_fem._report.clocks import picture_of_clock
from pvlib_fem._report.evidence import pictures_of, power_shortfall
from pvlib_fem._report.page_pictures import draw
from pvlib_fem._report.rows import Rows

if TYPE_CHECKING:
    from pvlib_fem._loop.results.loop_result import Loop

NONE = (
    "No column of this record shows it without the model. The maps below show the "
    "error before and after all findings."
)


@dataclass(frozen=True)
class Shown:
    """A finding in a sentence, its pictures, and a note where there are none."""

    text: str
    pictures: list[tuple[str, str]]
    note: str = ""


def findings_with_pictures(loop: "Loop", statements: pd.DataFrame) -> list[Shown]:
    """
    Clocks, findings in the model and events, each with its pictures.

    Parameters
    ----------
    loop : Loop
        With its rows.
    statements : DataFrame
        As ``loop.statements``.

    Returns
    -------
    list of Shown
    """
    texts, order = events.texts_by_cause(statements), {}
    for i, cause in enumerate(statements["cause"]):
        order.setdefault(cause, i)
    items = [
        (one.fault, [picture] if (picture := picture_of_clock(one, loop)) else [])
        for one in loop.corrections
        if not one.of_place
    ]
    items += [(f.effect, pictures_of(f, loop)) for f in loop.finding_objects if f.added]
    names = {name for name, _ in items}
    for name in events.by_kind(loop):
        if name not in names:
            picture = power_shortfall(Rows(loop), name)
            items.append((name, [picture] if picture else []))
    # the order of the statements, the most valuable first
    items.sort(key=lambda pair: order.get(pair[0], len(order)))
    return [
        Shown(
            texts.get(name, name),
            [
                draw(f"evidence{i}-{j}", one.draw, one.words, one.projection)
                for j, one in enumerate(pictures)
            ],
            "" if pictures else NONE,
        )
        for i, (name, pictures) in enumerate(items)
    ]
