"""Every threshold by which the loop decides, in one place."""

from dataclasses import dataclass, field, replace

from pvlib_fem._former_names import fields_in_new_names
from pvlib_fem.quality._limits import Limits

HALF = 0.5  # probability above which something is more probable than not
TINY = 1e-12  # of the error: a hint is of any share

#: former names of thresholds
RENAMED = {
    "enough_days": "min_days",
    "max_missing": "max_missing_share",
    "leak": "min_leak_difference",
    "min_gain": "min_rmse_reduction",
    "min_share": "min_error_share",
    "hint_gain": "min_hint_reduction",
    "probability": "min_probability",
    "prior": "prior_odds",
    "outside": "outside_probability",
    "change_side": "min_days_each_side",
    "episode_chance": "max_episode_chance",
}


@fields_in_new_names(RENAMED)
@dataclass(frozen=True, kw_only=True)
class Criteria:
    """
    Every threshold by which :func:`pvlib_fem.close_loop` decides.

    A change is made by ``Criteria(min_rmse_reduction=0.1)`` and given as ``criteria=``.
    What each does, halved and doubled, to the records of the study is in
    :doc:`/sensitivity`; how the loop decides by them is in :doc:`/design`.

    Attributes
    ----------
    min_days : int
        Days that count, below which no cause is added to the model. [days]
    max_missing_share : float
        Share of a driver's rows that may be missing; a driver with more gaps is not
        used. [-]
    min_leak_difference : float
        A column that follows the measured temperature as a whole is made from it and
        is not used, unless the modelled temperature with more of the residual
        describes more of the column by at least this share of what the remaining
        error describes. [-]
    search_step : float
        Step of the means on which effects are searched; the last fit is to the
        record's own steps. [s]
    test_every : int
        One of this many weeks is a test week, whose module temperature no decision
        sees. [weeks]
    min_rmse_reduction : float
        Least gain of an effect: root of the reduction of the mean square error on
        weeks left out in turn, and on all fitting weeks. The default is a third of the
        0.4 K of a contact sensor. The gain of a tracker's standstill counts on the days
        on which it stands. [K]
    min_error_share : float
        The material gain as a share of the mean square error of the model without
        effects. [-]
    min_hint_reduction : float
        Gain from which an effect that was not added is reported as a hint. [K]
    min_probability : float
        Probability from which a cause is identified, and that a set of causes holds
        together. [-]
    prior_odds : float
        Odds, before the data are seen, that any one effect of the catalogue acts on
        a record. [-]
    outside_probability : float
        Probability, before the data are seen, that a cause outside the catalogue
        makes what an effect of the catalogue explains. [-]
    law_error : float
        Relative error of an effect's law: by so much a true effect may explain less
        than another with the same inputs. [-]
    shape_error : float
        Relative error of the law of effects that are functions of the usual inputs
        alone. [-]
    min_days_each_side : int
        Days with rows that there have to be before and after the date of a change. A
        temporary change lasts for seven of them at least. [days]
    max_episode_chance : float
        Chance that noise shows any days that stand out, which are reported and
        decide nothing. [-]
    limits : Limits
        Thresholds of what is checked of sensors and clocks before any fit.
    """

    min_days: int = 60
    max_missing_share: float = 0.2
    min_leak_difference: float = 0.05
    search_step: float = 300.0
    test_every: int = 5

    min_rmse_reduction: float = 0.15
    min_error_share: float = 0.0125
    min_hint_reduction: float = 0.10

    min_probability: float = 0.95
    prior_odds: float = 0.025
    outside_probability: float = 0.07
    law_error: float = 0.22
    shape_error: float = 0.33

    min_days_each_side: int = 21
    max_episode_chance: float = 0.01

    limits: Limits = field(default_factory=Limits)

    @property
    def for_hints(self) -> "Criteria":
        """The criteria of a hint, which is a finding that is not in the model."""
        return replace(
            self,
            min_rmse_reduction=self.min_hint_reduction,
            min_error_share=TINY,
            min_probability=HALF,
        )

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if name != "limits" and not value > 0:
                raise ValueError(f"{name} = {value} must be more than 0")
