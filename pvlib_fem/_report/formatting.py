"""Numbers and their errors as a reader needs them."""

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from pvlib_fem._fitting.fem_fit import FemFit


def two_decimals(value: float) -> str:
    """
    Two decimals, without a negative zero; a dash where there is none.

    Parameters
    ----------
    value : float
        Any number; NaN or infinity is a dash.

    Returns
    -------
    str
    """
    return f"{value:z.2f}" if np.isfinite(value) else "–"


def two_digits(error: float) -> str:
    """
    Two digits, and never 2e+03; a dash where there is none.

    Parameters
    ----------
    error : float
        Any number; NaN or infinity is a dash.

    Returns
    -------
    str
    """
    return f"{float(f'{error:.2g}'):g}" if np.isfinite(error) else "–"


def range_text(low: float, high: float) -> str:
    """
    From and to, to two digits of half of what is between them.

    Parameters
    ----------
    low, high : float
        Ends of a range. If ``high`` is not above ``low``, only ``low`` is shown.

    Returns
    -------
    str
    """
    half = (high - low) / 2.0
    if not half > 0:
        return f"{low:.4g}"
    digits = max(0, 1 - int(np.floor(np.log10(float(f"{half:.1e}")))))
    return f"{low:z.{digits}f} … {high:z.{digits}f}"


def value_and_error(fit: "FemFit", name: str) -> tuple[str, str]:
    """
    Cells of a table: a coefficient and its error.

    Parameters
    ----------
    fit : FemFit
        Fit with this coefficient.
    name : str
        Name of the coefficient.

    Returns
    -------
    (str, str)
        Value and standard error; the latter is "held" for a fixed coefficient and a
        dash where it is not known.
    """
    value, error = fit.coefficients[name], fit.stderr[name]
    if name in fit.fixed:
        return f"{value:.5g}", "held"
    if not error > 0:
        return f"{value:.5g}", "–"
    size, _, margin = with_error(value, error).partition(" ± ")
    return size, margin


def constants_of(fit: "FemFit") -> list[tuple[str, str, str]]:
    """
    The constants of a fit's steady model, without which its coefficients say little.

    Parameters
    ----------
    fit : FemFit

    Returns
    -------
    list of (str, str, str)
        Name, value, and "held" if the user gave it, otherwise "default".
    """
    return [
        (name, f"{value:.5g}", "held" if name in fit.fixed else "default")
        for name, value in fit.thermal_model.constants.items()
    ]


def with_error(value: float, error: float) -> str:
    """
    A value to the two digits of its error, and that; alone without one.

    Parameters
    ----------
    value : float
        Any number.
    error : float
        Its standard error, in the same unit; without one if it is not finite or not
        positive.

    Returns
    -------
    str
    """
    if not (np.isfinite(error) and error > 0):
        return f"{value:.4g}"
    last = int(np.floor(np.log10(float(f"{error:.1e}")))) - 1  # place of both
    digits = max(0, -last)
    value, error = round(value, -last), round(error, -last)
    return f"{value:z.{digits}f} ± {error:.{digits}f}"
