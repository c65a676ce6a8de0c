"""How much could still be explained, as a sentence."""

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from pvlib_fem._ceiling.ceiling_result import Ceiling


def ceiling_sentence(ceiling: "Ceiling") -> str:
    """
    What the loop explains of the error that trees on the same columns explain.

    Parameters
    ----------
    ceiling : Ceiling
        Errors of the paper's form, the loop and the trees on the test weeks.

    Returns
    -------
    str
        One sentence with the errors [K] and the share that the loop explains.
    """
    patterns = ceiling.loop < ceiling.causes  # False where the causes are not known
    own = f"the loop {ceiling.loop:.2f} K"
    if patterns:
        own += f" ({ceiling.causes:.2f} K without unexplained patterns)"
    errors = (
        f"On the test weeks the paper's form leaves {ceiling.paper:.2f} K, {own}, and "
        f"boosted trees on the same columns {ceiling.trees:.2f} K"
    )
    if np.isnan(ceiling.closed):
        return f"{errors}: the trees find nothing in them that could be closed."
    words = f"the loop closes {100 * ceiling.closed:.0f} % of the squared error"
    if patterns:
        words += f" ({100 * ceiling.share(ceiling.causes):.0f} % by causes)"
    lost = ""
    if ceiling.most:
        error = ceiling.without[ceiling.most]
        lost = f"; the trees lose most without {ceiling.most} ({error:.2f} K)"
    return f"{errors}: {words} that the trees close{lost}."
