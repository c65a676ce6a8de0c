"""Store a loop in a file, and read it."""

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, TypedDict

import pandas as pd
from pvlib.location import Location

from pvlib_fem._budget.covers_and_outages import event_rows, events_from
from pvlib_fem._budget.error_budget import (
    BudgetRow,
    EpisodeRow,
    budget_rows,
    budget_table,
    episode_rows,
    episode_table,
)
from pvlib_fem._ceiling.ceiling_result import Ceiling
from pvlib_fem._converter import AnyFloat
from pvlib_fem._findings import Correction, Finding
from pvlib_fem._fitting.fem_fit import FemFit
from pvlib_fem._fitting.fit_files import fit_content
from pvlib_fem._fitting.stand_ins import StandIn
from pvlib_fem._loop.criteria import Criteria
from pvlib_fem._loop.ranking.ranking_table import RankingRow, ranking_rows, table_of
from pvlib_fem._loop.results.corrected_times import Times
from pvlib_fem._loop.results.predicted_patterns import Pattern
from pvlib_fem._modelchain import fit_in
from pvlib_fem._report.event_text import EVENT
from pvlib_fem._statements.statement import key_of
from pvlib_fem._stored import Stored
from pvlib_fem._thermal.model_files import content_of, model_of
from pvlib_fem.drivers._mounts import mount_content, mount_from
from pvlib_fem.effects import EffectLike
from pvlib_fem.quality._detached_sensor import Detachment
from pvlib_fem.quality._limits import Limits
from pvlib_fem.quality._tracker_standstill import Standing
from pvlib_fem.reasons import Because

if TYPE_CHECKING:
    from pvlib_fem._loop.results.loop_result import Loop


class Reading(TypedDict, total=False):
    """How the data of a loop were read."""

    rows: int
    notes: list[str]


def loop_content(loop: "Loop", cell: dict[str, float]) -> dict[str, Any]:
    """
    Content of a file of a loop.

    Parameters
    ----------
    loop : Loop
        Loop with or without its rows.
    cell : dict
        ``deltaT`` or ``k_bs_c``; if it is empty, that of the fit.

    Returns
    -------
    dict
        Objects by their names in the file.
    """
    return {
        "findings": loop.finding_objects,
        "statements": loop.statement_objects,
        "corrections": loop.corrections,
        "table": loop.table.to_dict(orient="index"),
        "base": loop.base,
        "last": loop.last,
        "untestable": loop.untestable,
        "ranking": ranking_rows(loop.ranking),
        "budget": budget_rows(loop.budget),
        "episodes": episode_rows(loop.episodes),
        "events": event_rows(loop.events),
        "notes": loop.notes,
        "place": place_content(loop.place),
        "weeks": loop.week_rows,
        "plain": content_of(*loop.plain),
        "criteria": loop.criteria,
        "weighed": loop.weighed,
        "ceiling": loop.known_ceiling,
        "given": loop.given,
        "times": loop.times,
        "transposition": loop.transposition,
        "stand_ins": loop.stand_ins,
        "reading": loop.reading,
        "standings": loop.standings,
        "detachments": loop.detachments,
        "patterns": loop.patterns,
        "label": loop.label,
        "fit": fit_content(loop.fit, cell),
    }


def loop_parts(
    content: Stored, own: EffectLike | Iterable[EffectLike]
) -> tuple[dict[str, Any], dict[str, Any]]:
    """
    Attributes of a loop in a file, and those that are computed from rows otherwise.

    Parameters
    ----------
    content : Stored
        Content of the file.
    own : Effect or sequence of these
        The user's own effects, of which the file has only name and settings.

    Returns
    -------
    attributes : dict
        Arguments of ``Loop``.
    computed : dict
        ``week_rows``, ``yearly_energy`` and, if it is in the file, ``own_ceiling``.
    """
    rows = content.read("table", dict[str, dict[str, AnyFloat]])
    for name in ("base", "last"):
        if (step := content.read(name, str)) not in rows:
            raise ValueError(
                f"{content.file}: {name} is {step!r}, and no row of the table: "
                f"{', '.join(rows)}"
            )
    criteria = content.part("criteria").content
    limits = Limits(**criteria["limits"])
    attributes = dict(
        finding_objects=content.read("findings", tuple[Finding, ...]),
        corrections=content.read("corrections", tuple[Correction, ...]),
        table=pd.DataFrame.from_dict(rows, orient="index").rename_axis("step"),
        base=content.read("base", str),
        last=content.read("last", str),
        untestable=content.read("untestable", dict[str, Because]),
        ranking=table_of(content.read("ranking", dict[str, RankingRow])),
        fit=FemFit.stored(fit_in(content), own),
        budget=budget_table(content.read("budget", list[BudgetRow])),
        episodes=episode_table(content.read("episodes", list[EpisodeRow])),
        events=events_from(content.parts("events")),
        notes=content.read("notes", tuple[str, ...]),
        place=place_from(content.part("place")),
        plain=model_of(content.part("plain"), own),
        criteria=Criteria(**criteria | {"limits": limits}),
        weighed=content.read("weighed", bool),
        given=content.read("given", dict),
        times=content.read("times", Times | None),
        transposition=content.read("transposition", str, ""),
        stand_ins=content.read("stand_ins", tuple[StandIn, ...], ()),
        reading=content.read("reading", Reading, {}),
        standings=content.read("standings", tuple[Standing, ...], ()),
        detachments=content.read("detachments", tuple[Detachment, ...], ()),
        patterns=content.read("patterns", tuple[Pattern, ...], ()),
        label=content.read("label", float, 0.0),
    )
    computed = {
        "week_rows": content.read("weeks", dict[str, int]),
        "yearly_energy": energies_in(content),
    }
    if ceiling := content.read("ceiling", Ceiling | None):
        computed["own_ceiling"] = ceiling
    return attributes, computed


def energies_in(content: Stored) -> dict[str, float]:
    """
    Energies of the statements of a file; files before them have none.

    Those of events are in their table.
    """
    if "statements" not in content.content:
        return {}
    return {
        key_of(one.read("cause", str), one.read("since", str)): one.read(
            "energy", float
        )
        for one in content.parts("statements")
        if one.content.get("energy") is not None and one.read("verdict", str) != EVENT
    }


def place_content(place: dict[str, Any]) -> dict[str, Any]:
    """A place for a file."""
    where = place["location"]
    if where is not None:
        names = ("latitude", "longitude", "tz", "altitude", "name")
        where = {name: getattr(where, name) for name in names}
    content = {**place, "location": where, "mount": mount_content(place["mount"])}
    return {name: v for name, v in content.items() if name != "mount" or v is not None}


def place_from(stored: Stored) -> dict[str, Any]:
    """The place of a part of a file."""
    place = dict(stored.content)
    if place["location"] is not None:
        place["location"] = Location(**place["location"])
    place["mount"] = mount_from(place.get("mount"))  # none in files of before
    return place
