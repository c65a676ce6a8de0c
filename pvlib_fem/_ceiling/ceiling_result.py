"""A ceiling: finished, and it prints itself."""

from dataclasses import dataclass, field

import numpy as np

from pvlib_fem._converter import AnyFloat


@dataclass(frozen=True)
class Ceiling:
    """
    Errors on the test weeks: of a loop, and of trees on the same columns.

    ``print(ceiling)`` is one sentence.

    Attributes
    ----------
    paper, loop, trees : float
        RMSE of the paper's form, which has no effects, of the loop with its unexplained
        patterns, and of the trees. [K]
    rows : int
        Rows of test weeks that all three are of.
    without : dict of float
        RMSE of trees without a group of columns: ``power``, ``wind``, ``other
        columns``, ``past values``, ``hour and season`` with the place of the sun, and
        ``date``, as far as the record has them. [K]
    causes : float
        RMSE of the loop with the causes alone that were found. [K]
    """

    paper: float
    loop: float
    trees: float
    rows: int
    without: dict[str, float] = field(default_factory=dict)
    causes: AnyFloat = np.nan

    @property
    def closed(self) -> float:
        """
        Share of the closable squared error that the loop closes; NaN where none is.

        With the RMSE of the paper's form, the loop and the trees it is
        ``(paper² - loop²) / (paper² - trees²)``. [-]
        """
        return self.share(self.loop)

    def share(self, error: float) -> float:
        """Share of the closable squared error that a model with an RMSE closes. [-]"""
        closable = self.paper**2 - self.trees**2
        return (self.paper**2 - error**2) / closable if closable > 0 else np.nan

    @property
    def most(self) -> str:
        """The group without which the trees lose most; "" if they lose without none."""
        name = max(self.without, key=lambda name: self.without[name], default="")
        return name if name and self.without[name] > self.trees else ""

    def __str__(self) -> str:
        from pvlib_fem._report.ceiling_text import ceiling_sentence

        return ceiling_sentence(self)
