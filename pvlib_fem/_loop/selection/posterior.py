"""How probable each candidate of one single effect is: their posterior."""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from pvlib_fem._loop.criteria import Criteria
from pvlib_fem._loop.regression.design import Column, Design, place_of
from pvlib_fem._loop.selection.change_sums import dates_cost
from pvlib_fem._statistics.weekly_sums import (
    LeastSquares,
    common_share,
    fall_of_squares,
    given_first,
)

if TYPE_CHECKING:
    from pvlib_fem._loop.selection.dictionary import Candidate

DRAWS = 40  # of weeks, with replacement


def posterior(
    design: Design,
    criteria: Criteria,
    members: Mapping[str, "Candidate"],
    given: Sequence[Column],
    top: "Candidate",
    sure: float,
) -> dict[str, float]:
    """
    Posterior among members of one single effect, averaged over draws of weeks.

    What the best one still explains given another is compared with the error of the
    laws: an exact likelihood of so many rows would be sure of a law that is not exact
    (Huggins and Miller, 2023). By its error, a law is worth so many observations as its
    inverse square says, and each coefficient costs half of their logarithm.

    Parameters
    ----------
    design : Design
    criteria : Criteria
        With the errors of the laws.
    members : dict of Candidate
        All that may be the effect, by name.
    given : sequence of int or Changed
        Columns given which each is weighed.
    top : Candidate
        The best one among them.
    sure : float
        What it explains, in its standard errors.

    Returns
    -------
    dict of float
        Probability of each member; their sum is 1.
    """
    design = design.fit_for(one.effect for one in members.values())
    if len(members) == 1:
        return {top.name: 1.0}
    random = np.random.default_rng(0)
    weeks = len(design.clusters)
    draws = random.multinomial(weeks, np.full(weeks, 1.0 / weeks), DRAWS)
    draws = draws.astype(float)
    parts = [drawn_part(design, one, given, draws) for one in members.values()]
    parts = np.maximum(np.array(parts), 0.0)
    most = np.maximum(parts[[*members].index(top.name)], 1e-12)
    common, mine = np.empty_like(parts), top.beyond(given)
    for i, one in enumerate(members.values()):
        rival = one.beyond(given)
        wholes = sums_of_draws(design.by_week([*given, *mine, *rival]), draws)
        common[i] = common_share(wholes, len(mine), len(rival))
    shapes = any(one.effect.confounder for one in members.values())
    law = (criteria.shape_error if shapes else criteria.law_error) ** 2
    # time profiles of one fault differ by no error of its law
    groups: dict[str, list[int]] = {}
    logs = np.empty_like(parts)
    for i, one in enumerate(members.values()):
        groups.setdefault(one.effect.sensor_fault or one.name, []).append(i)
    costs = np.array([[dates_cost(one.dates, sure)] for one in members.values()])
    for same in groups.values():
        within = 0.5 * sure**2 * parts[same] / most
        within -= costs[same]
        within -= within.max(axis=0)
        within -= np.log(np.exp(within).sum(axis=0))
        logs[same] = within - 0.5 * (1.0 - common[same].max(axis=0)) / law
    logs += np.array([[one.log_prior] for one in members.values()])
    # a law of two coefficients fits part of another one's error (Schwarz, 1978)
    sizes = np.array([[len(one.beyond(given))] for one in members.values()])
    logs -= 0.5 * np.log1p(1.0 / law) * sizes
    # faults of one law share its prior
    places = [place_of(one.columns[0]) for one in members.values()]
    faults = Counter(places[same[0]] for same in groups.values())
    logs -= np.log([[faults[place]] for place in places])
    shares = np.exp(logs - logs.max(axis=0))
    shares = (shares / shares.sum(axis=0)).mean(axis=1)
    return dict(zip(members, shares.tolist()))


def drawn_part(
    design: Design, one: "Candidate", given: Sequence[Column], draws: np.ndarray
) -> np.ndarray:
    """
    Fall of the mean square by a candidate in draws of weeks, less noise.

    ``draws`` says how often each week is drawn, shape (draws, weeks).
    """
    own = one.beyond(given)
    weekly = design.by_week([*given, *own])
    fit = LeastSquares(weekly, len(own))
    # Takeuchi: what as many columns take of noise that is alike within weeks
    own_part = given_first(fit.whole, len(given))[1:, 1:]
    noise = np.trace(own_part @ fit.covariance)
    return (
        fall_of_squares(sums_of_draws(weekly, draws), len(own)) - noise
    ) / design.count


def sums_of_draws(weekly: np.ndarray, draws: np.ndarray) -> np.ndarray:
    """Sums of products over each draw of weeks."""
    return np.einsum("dw,wij->dij", draws, weekly)
