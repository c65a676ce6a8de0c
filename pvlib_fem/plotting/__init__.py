"""Pictures of fits, of loops and of their residuals.

Each function takes the axes to draw on, or makes a new figure, and returns the axes.
matplotlib is imported only in this package, and only when a picture is drawn. Text and
axes follow matplotlib's style, light or dark. Every colour has its own line style,
marker or sign, too.
"""

from pvlib_fem.plotting._budget_plot import plot_budget
from pvlib_fem.plotting._ceiling_plot import plot_ceiling
from pvlib_fem.plotting._comparisons import (
    plot_comparison,
    plot_energy_error,
    plot_resolutions,
)
from pvlib_fem.plotting._dynamics_plots import (
    plot_step_response,
    plot_tau_by_wind,
    tau_by_wind,
)
from pvlib_fem.plotting._monthly_plot import plot_through_time
from pvlib_fem.plotting._recovery import plot_recovery
from pvlib_fem.plotting._residuals import (
    plot_residual_by,
    plot_residual_map,
    plot_residual_rose,
)
from pvlib_fem.plotting._step_plots import plot_steps, plot_waterfall
from pvlib_fem.plotting._style import AFTER, BEFORE, COLOURS, OTHER
from pvlib_fem.plotting._time_series import (
    plot_before_after,
    plot_contributions,
    plot_fit,
)

__all__ = [
    "AFTER",
    "BEFORE",
    "COLOURS",
    "OTHER",
    "plot_before_after",
    "plot_budget",
    "plot_ceiling",
    "plot_comparison",
    "plot_contributions",
    "plot_energy_error",
    "plot_fit",
    "plot_recovery",
    "plot_residual_by",
    "plot_residual_map",
    "plot_residual_rose",
    "plot_resolutions",
    "plot_step_response",
    "plot_steps",
    "plot_tau_by_wind",
    "plot_through_time",
    "plot_waterfall",
    "tau_by_wind",
]
