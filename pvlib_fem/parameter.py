"""What a fitted parameter is: where it starts, its bounds and its unit."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Parameter:
    """
    One row of a parameter table.

    ``share_of`` names another parameter of which start and bounds are shares:
    the fit then runs over that share, so that a bound which moves with the
    other parameter stays a plain bound.
    """

    start: float
    lower: float
    upper: float
    unit: str
    share_of: str | None = None
