"""The result of injections into a record."""

from dataclasses import dataclass, field
from typing import Any, Self

import numpy as np
import pandas as pd
from scipy.special import expit

from pvlib_fem._findings import Finding
from pvlib_fem._record.column_names import printable
from pvlib_fem._recovery.judge import Outcome
from pvlib_fem._recovery.recovery_text import lines
from pvlib_fem._recovery.trial import Trial, rates
from pvlib_fem._stored import Stored, as_json, opened, written
from pvlib_fem.types import FilePath

FORMAT = "pvlib_fem recovery"
#: of the curve of shares found: factor beyond the injected sizes, widths in logarithms
REACH, WIDTHS = 4.0, np.geomspace(0.05, 1.0, 20)
TAIL = 0.05  # probability beyond either end of the half size's interval
COLUMNS = ("found", "first", "wrong", "misled", "lost", "refused")


@dataclass(frozen=True, eq=False)
class Recovery:
    """
    Injected effects that a loop finds in a measured record.

    ``print(recovery)`` is the table by effect.

    Attributes
    ----------
    outcomes : tuple of Outcome
        Outcomes in the order of the plan.
    planned : int
        Number of planned injections; there are fewer outcomes after an interrupt.
    baseline : tuple of Finding
        Findings of the loop in the record itself.
    units : dict
        Units of the coefficients, by effect.
    notes : dict
        Effects that were not injected, and why.
    trials : tuple of Trial
        Scrambled records, and false names in them.
    planned_trials : int
        Number of planned trials.
    not_scrambled : dict
        Kinds of scrambling that the record does not allow, and why.
    given : dict
        Arguments of the call, as text.
    version, sha256 : str
        Version of the package, and hash of the record.
    """

    given: dict[str, str] = field(repr=False)
    version: str
    sha256: str
    outcomes: tuple[Outcome, ...] = ()
    planned: int = 0
    baseline: tuple[Finding, ...] = field(repr=False, default=())
    units: dict[str, dict[str, str]] = field(repr=False, default_factory=dict)
    notes: dict[str, str] = field(repr=False, default_factory=dict)
    trials: tuple[Trial, ...] = ()
    planned_trials: int = 0
    not_scrambled: dict[str, str] = field(repr=False, default_factory=dict)

    @property
    def table(self) -> pd.DataFrame:
        """
        A row for each injection.

        Columns of the injection: ``effect``, ``draw``, ``dates``, ``coefficients``,
        their ``size``, the size from which it should be found (``predicted``), the
        ratio of both (``multiple``), and the estimate in the record itself (``own``).

        Columns of the outcome: whether it is ``found`` among the candidates of a
        finding (a fault also on about its days), ``identified``, and the ``first``
        finding that the record itself does not show; all such findings
        (``reported``), ``wrong`` causes that are identified among them, ambiguous ones
        without the truth (``misled``), and findings of the record itself that are
        ``lost``; the ``ratio`` of coefficient and truth, whether the truth is
        ``covered`` by 1.96 standard errors and within the range (``in_range``), and
        half the width of the range relative to the truth (``half_range``), NaN if it
        is not in the model; and why the loop ``refused`` the record.
        """
        rows = []
        for outcome in self.outcomes:
            injection, row = outcome.injection, vars(outcome).copy()
            del row["injection"]
            own = {**vars(injection), "dates": injection.dates}
            own["multiple"] = injection.multiple
            rows.append({**own, **row})
        names = [*Outcome.__dataclass_fields__][1:]
        head = ["effect", "draw", "dates", "coefficients", "size", "predicted"]
        return pd.DataFrame(rows, columns=[*head, "multiple", "own", *names])

    @property
    def summary(self) -> pd.DataFrame:
        """
        A row for each effect and multiple of the predicted size.

        ``injections``; shares ``found`` at all, ``first``, with a wrong name
        (``wrong``), with an ambiguous finding without the truth (``misled``), with a
        finding of the record itself that is no longer there (``lost``), and
        ``refused``; median ``ratio`` of coefficient and truth, and the shares
        ``covered`` by its error of 95 % and within its range (``in_range``).
        """
        table = self.table
        for name in COLUMNS[2:]:
            table[name] = table[name].map(bool)
        by = table.groupby(["effect", "multiple"], sort=False, dropna=False)
        shares = by[[*COLUMNS]].mean()
        shares.insert(0, "injections", by.size())
        shares["ratio"] = by["ratio"].median()
        return shares.join(by[["covered", "in_range"]].mean())

    @property
    def half(self) -> pd.DataFrame:
        """
        The size at which half of the injections are found, a row for each effect.

        It is given as a multiple of the predicted size (``multiple``), with a 90 %
        interval (``lower``, ``upper``), and as a ``size`` of the coefficient, by the
        median of the ``predicted`` sizes. The numbers are the median and interval of
        the middle of a logistic curve in the logarithm of the multiple. Its prior is
        uniform from a quarter of the smallest multiple to four times the largest, with
        widths from 0.05 to 1. If all or no injections are found, the interval ends
        beyond the injected sizes.
        """
        rows, table = {}, self.table
        for name, part in table.groupby("effect", sort=False):
            part = part[part["multiple"] > 0.0]
            if part.empty:
                continue
            middle = middle_of(part["multiple"].to_numpy(), part["found"].to_numpy())
            predicted = float(part["predicted"].median())
            keys = ("lower", "multiple", "upper")
            rows[name] = {"predicted": predicted, "size": middle[1] * predicted}
            rows[name] |= dict(zip(keys, middle))
        head = ["predicted", "size", "multiple", "lower", "upper"]
        return pd.DataFrame.from_dict(rows, orient="index", columns=head).rename_axis(
            "effect"
        )

    @property
    def reliability(self) -> pd.DataFrame:
        """
        Completeness and reliability, a row for each effect.

        ``identified`` is whether it is identified in the record itself. ``injections``
        is the number of injections of at least 1.5 times the predicted size, ``found``
        how many of these are found, and ``completeness`` the ratio. ``trials`` is the
        number of scrambled records that have lost the effect, ``false`` how many name
        it, and ``reliability`` the share of the others. Each share has a 90 % interval
        by Jeffreys' prior (``complete_from``, ``complete_to``, ``reliable_from``,
        ``reliable_to``), or is NaN without data.
        """
        return rates(self.outcomes, self.trials, self.baseline)

    def plot(self, ax: Any = None) -> Any:
        """
        Plot the share found over multiples of the predicted size, by effect.

        Parameters
        ----------
        ax : matplotlib Axes, optional

        Returns
        -------
        matplotlib Axes
        """
        from pvlib_fem import plotting

        return plotting.plot_recovery(self, ax)

    def to_json(self, path: FilePath | None = None) -> str:
        """
        The recovery as JSON, which :meth:`from_json` reads.

        Parameters
        ----------
        path : str or path-like, optional
            File to write.

        Returns
        -------
        str
        """
        return written(FORMAT, self.content(), path)

    def content(self) -> dict:
        """Content of a file of the recovery."""
        content = as_json(self)
        # in a file, version is that of its format
        return {"version_of_package": content.pop("version"), **content}

    @classmethod
    def from_json(cls, path: FilePath) -> Self:
        """
        The recovery that :meth:`to_json` wrote.

        Parameters
        ----------
        path : str or path-like

        Returns
        -------
        Recovery

        Raises
        ------
        ValueError
            If the file is of another kind or version, or a value is missing or
            invalid; the message names the key.
        """
        with opened(path, [FORMAT]) as stored:
            content = {**stored.content, "version": stored["version_of_package"]}
            return Stored(content, stored.file).whole(cls)

    def __str__(self) -> str:
        return printable("\n".join(lines(self)), "\n")

    def _repr_html_(self) -> str:
        tables = [self.summary] + [self.reliability] * bool(self.trials)
        how: dict[str, Any] = dict(float_format="{:.2f}".format, na_rep="–")
        return "\n".join(table.to_html(**how) for table in tables)


def middle_of(multiples: np.ndarray, hits: np.ndarray) -> tuple[float, float, float]:
    """Lower end, median and upper end of the size at which half are found."""
    x = np.log(multiples)
    places = np.linspace(x.min() - np.log(REACH), x.max() + np.log(REACH), 400)
    curve = expit(
        (x - places[:, None, None]) / WIDTHS[:, None]
    )  # places, widths, injections
    chance = np.where(hits, curve, 1.0 - curve)
    logs = np.log(np.maximum(chance, 1e-12)).sum(axis=-1)
    likely = np.exp(logs - logs.max()).sum(axis=1)
    below = np.cumsum(likely) / likely.sum()
    ends = np.interp([TAIL, 0.5, 1.0 - TAIL], below, places)
    return tuple(np.exp(ends).tolist())
