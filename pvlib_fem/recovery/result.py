"""The result of injections into a record: finished, and it prints itself."""

from dataclasses import asdict, dataclass, field
from typing import Any, Self

import numpy as np
import pandas as pd
from scipy.special import expit

from pvlib_fem import plotting
from pvlib_fem.findings import Finding
from pvlib_fem.record.columns import printable
from pvlib_fem.recovery.judge import Outcome
from pvlib_fem.recovery.text import lines
from pvlib_fem.recovery.trial import Trial, rates
from pvlib_fem.stored import Stored, opened, written
from pvlib_fem.types import FilePath

FORMAT = "pvlib_fem recovery"
#: of the curve of shares found: sizes beyond those injected, widths in logarithms
REACH, WIDTHS = 4.0, np.geomspace(0.05, 1.0, 20)
TAIL = 0.05  # of the half size's interval, on either side
COLUMNS = ("found", "first", "wrong", "misled", "lost", "refused")


@dataclass(frozen=True, eq=False)
class Recovery:
    """
    What a loop finds of effects that were put into a measured record.

    ``print(recovery)`` is the table by effect.

    Attributes
    ----------
    outcomes : tuple of Outcome
        In the order of the plan.
    planned : int
        Injections in all; more than there are outcomes where it was interrupted.
    baseline : tuple of Finding
        What the loop finds in the record as it is.
    units : dict
        By effect the unit of each coefficient.
    notes : dict
        Effects that were not put in, and why.
    trials : tuple of Trial
        Records that were scrambled, and what is named falsely in them.
    planned_trials : int
        Of these in all.
    not_scrambled : dict
        Kinds of scrambling that the record does not allow, and why.
    given : dict
        Arguments of the call, as they are written.
    version, sha256 : str
        Of the package, and of the record.
    """

    given: dict = field(repr=False)
    version: str
    sha256: str
    outcomes: tuple = ()
    planned: int = 0
    baseline: tuple = field(repr=False, default=())
    units: dict = field(repr=False, default_factory=dict)
    notes: dict = field(repr=False, default_factory=dict)
    trials: tuple = ()
    planned_trials: int = 0
    not_scrambled: dict = field(repr=False, default_factory=dict)

    @property
    def table(self) -> pd.DataFrame:
        """
        A row for each injection.

        ``effect``, ``draw``, ``dates``, ``coefficients``, their ``size`` and the size
        from which it should be found (``predicted``), the one over the other
        (``multiple``), what the record itself has of it (``own``), and of its outcome:
        whether it is ``found`` by name or in a class (of a change about the same days),
        ``named``, and the ``first`` of what the record itself does not show; all of
        that that is ``told``, ``wrong`` names, classes without the truth (``misled``)
        and findings of the record itself that are ``lost``; the ``ratio`` of
        coefficient and truth, whether the truth is ``covered`` by 1.96 standard errors
        and within the range (``in_range``), half of whose width is ``half_range`` of
        the truth, NaN where it is not in the model; why the
        loop ``refused`` the record.
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
        (``wrong``), with a class without the truth (``misled``), with a finding of
        the record itself that is no longer there (``lost``), and ``refused``; median
        ``ratio`` of coefficient and truth, and the shares ``covered`` by its error of
        95 % and within its range (``in_range``).
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
        The size of which half are found, a row for each effect.

        As a multiple of the predicted size (``multiple``), with an interval of 90 %
        (``lower``, ``upper``), and as a ``size`` of the coefficient by the median of
        the ``predicted`` sizes. A logistic curve in the logarithm of the multiple,
        all places from a quarter of the smallest to four times the largest and all
        widths from 0.05 to 1 alike beforehand; the median and the interval of its
        middle. Where all are found, or none, it ends beyond the sizes injected.
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

        Whether the record itself has it ``named``. Of ``injections`` of at least 1.5
        times the predicted size how many are ``found``, and that share
        (``completeness``). Of ``trials``, scrambled records that have lost the effect,
        how many name it (``false``), and the share of the others (``reliability``).
        Each share has an interval of 90 % by Jeffreys' prior (``complete_from``,
        ``complete_to``, ``reliable_from``, ``reliable_to``); NaN where there is none.
        """
        return rates(self.outcomes, self.trials, self.baseline)

    def plot(self, ax: Any = None) -> Any:
        """
        Share found by multiple of the predicted size, a line for each effect.

        Parameters
        ----------
        ax : matplotlib Axes, optional

        Returns
        -------
        matplotlib Axes
        """
        return plotting.plot_recovery(self, ax)

    def to_json(self, path: FilePath | None = None) -> str:
        """
        All of it as JSON, of which :meth:`from_json` makes the same again.

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
        """What is in a file of the recovery."""
        return {
            "version_of_package": self.version,
            "sha256": self.sha256,
            "planned": self.planned,
            "given": self.given,
            "notes": self.notes,
            "units": self.units,
            "baseline": [finding.content() for finding in self.baseline],
            "outcomes": [asdict(outcome) for outcome in self.outcomes],
            "trials": [asdict(trial) for trial in self.trials],
            "planned_trials": self.planned_trials,
            "not_scrambled": self.not_scrambled,
        }

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
            If the file is of another kind or version, or something in it lacks or is
            not what belongs there; the message names the key.
        """
        with opened(path, [FORMAT]) as stored:
            return cls(
                outcomes=tuple(map(Outcome.stored, stored.parts("outcomes"))),
                planned=stored.count("planned"),
                baseline=tuple(map(Finding.stored, stored.parts("baseline"))),
                units=by_effect(stored.part("units")),
                notes=texts(stored.part("notes")),
                given=texts(stored.part("given")),
                version=stored.text("version_of_package"),
                sha256=stored.text("sha256"),
                trials=tuple(map(Trial.stored, stored.parts("trials"))),
                planned_trials=stored.count("planned_trials"),
                not_scrambled=texts(stored.part("not_scrambled")),
            )

    def __str__(self):
        return printable("\n".join(lines(self)), "\n")

    def _repr_html_(self):
        tables = [self.summary] + [self.reliability] * bool(self.trials)
        how: dict[str, Any] = dict(float_format="{:.2f}".format, na_rep="–")
        return "\n".join(table.to_html(**how) for table in tables)


def texts(stored: Stored):
    return {name: stored.text(name) for name in stored.content}


def by_effect(stored: Stored):
    return {name: texts(stored.part(name)) for name in stored.content}


def middle_of(multiples, found):
    """Median of the size at which half are found, between the ends of its interval."""
    x = np.log(multiples)
    places = np.linspace(x.min() - np.log(REACH), x.max() + np.log(REACH), 400)
    curve = expit(
        (x - places[:, None, None]) / WIDTHS[:, None]
    )  # places, widths, injections
    chance = np.where(found, curve, 1.0 - curve)
    logs = np.log(np.maximum(chance, 1e-12)).sum(axis=-1)
    likely = np.exp(logs - logs.max()).sum(axis=1)
    below = np.cumsum(likely) / likely.sum()
    ends = np.interp([TAIL, 0.5, 1.0 - TAIL], below, places)
    return tuple(np.exp(ends).tolist())
