"""The result of a comparison of models."""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import pandas as pd

from pvlib_fem._stored import saved
from pvlib_fem.types import FilePath

if TYPE_CHECKING:
    from matplotlib.axes import Axes

STEPS = ("standard", "filter", "ewm", "fem")
LEVELS = ("resolution", "model", "step")
FITTED = "fem"  # the last step of a model, and the only one of a comparator


@dataclass(frozen=True, eq=False)
class Comparison:
    """
    Errors of several models after each step; ``print(comparison)`` is the table.

    Attributes
    ----------
    table : DataFrame
        By ``resolution`` [s], ``model`` and ``step`` (``standard``, ``filter``,
        ``ewm``, ``fem``; a comparator has only the last): ``rmse``, ``mae``, ``mbe``
        [K] on held-out daytime rows, the same scores at night with the suffix
        ``_night``, and the number of daytime ``points``.
    coefficients : dict
        Fitted coefficients by resolution, model and step.
    notes : tuple of str
        Models that could not be fitted, and why.
    method : str
    """

    table: pd.DataFrame
    coefficients: dict = field(repr=False)
    notes: tuple
    method: str

    @property
    def resolutions(self) -> list[float]:
        """Steps of the compared records, the finest first. [s]"""
        return list(dict.fromkeys(self.table.index.get_level_values("resolution")))

    def by_step(
        self, score: str = "rmse", resolution: float | None = None
    ) -> pd.DataFrame:
        """
        One score as in the paper's Tables 4 and 5: a row per step, a column per model.

        Parameters
        ----------
        score : str, default "rmse"
            A column of ``table``.
        resolution : float, optional
            By default the finest. [s]

        Returns
        -------
        DataFrame

        Raises
        ------
        ValueError
            If there is no such score or resolution.
        """
        chosen = self.resolutions[0] if resolution is None else resolution
        if chosen not in self.resolutions:
            raise ValueError(
                f"no resolution {chosen:g} s; {self.resolutions} are there"
            )
        table = self.table.reset_index()
        return score_by_model(table[table["resolution"] == chosen], score, "step")

    def by_resolution(self, score: str = "rmse", step: str = FITTED) -> pd.DataFrame:
        """
        One score of one step as in the paper's Fig. 8, with a row per resolution.

        Parameters
        ----------
        score : str, default "rmse"
        step : str, default "fem"

        Returns
        -------
        DataFrame

        Raises
        ------
        ValueError
            If there is no such score or step.
        """
        if step not in STEPS:
            raise ValueError(f"unknown step {step!r}; they are {', '.join(STEPS)}")
        table = self.table.reset_index()
        return score_by_model(table[table["step"] == step], score, "resolution")

    def best(self, score: str = "rmse") -> str:
        """Name of the model with the least error at the finest resolution."""
        last = self.by_resolution(score).loc[self.resolutions[0]].dropna().abs()
        if last.empty:
            raise ValueError(f"no model has a score: {'; '.join(self.notes)}")
        return str(last.idxmin())

    def to_csv(self, path: FilePath | None = None) -> str:
        """
        The table as CSV.

        Parameters
        ----------
        path : str or path-like, optional
            File to write.

        Returns
        -------
        str
        """
        text = self.table.to_csv()
        saved(text, path)
        return text

    def plot(self, ax: "Axes | None" = None, score: str = "rmse") -> "Axes":
        """
        Plot lines over the steps, or over the resolutions if there are several.

        Parameters
        ----------
        ax : matplotlib Axes, optional
        score : str, default "rmse"

        Returns
        -------
        matplotlib Axes
        """
        from pvlib_fem import plotting

        if len(self.resolutions) > 1:
            return plotting.plot_resolutions(self, ax, score)
        return plotting.plot_comparison(self, ax, score)

    def __str__(self) -> str:
        lines = []
        for resolution in self.resolutions:
            lines += [f"steps of {resolution:g} s, held-out days, {self.method} [K]"]
            for score, words in (("rmse", "RMSE by day"), ("rmse_night", "by night")):
                lines += [
                    f"{words}",
                    self.by_step(score, resolution).to_string(
                        float_format="{:.2f}".format, na_rep="–"
                    ),
                    "",
                ]
        return "\n".join([*lines[:-1], *(f"note: {note}" for note in self.notes)])

    def _repr_html_(self) -> str:
        return self.table.to_html(float_format="{:.2f}".format, na_rep="–")


def score_by_model(table: Any, score: Any, rows: Any) -> Any:
    """One score with a column per model; rows and columns keep their order."""
    if score not in table:
        scores = ", ".join(name for name in table if name not in LEVELS)
        raise ValueError(f"unknown score {score!r}; they are {scores}")
    by_model = table.pivot_table(score, rows, "model", sort=False, dropna=False)
    return by_model.reindex(index=table[rows].unique(), columns=table["model"].unique())
