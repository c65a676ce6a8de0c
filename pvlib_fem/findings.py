"""What a closed loop can say."""

from dataclasses import dataclass, field

ADDED = ("named", "class")  # verdicts of what enters the model


@dataclass(frozen=True)
class Finding:
    """
    One thing that the record shows.

    Attributes
    ----------
    effect : str
        Name of the effect, or the drivers along which unknown structure lives.
    candidates : tuple of str
        All names that the data cannot tell from it, itself included.
    verdict : str
        ``"named"``; ``"class"``, one of the candidates; ``"suggestive"``, not
        added to the model; ``"unknown"``, which no effect explains.
    gain : float
        What it takes off the held-out error: root of the fall of its mean square,
        over weeks of the open part left out in turn. [K]
    coefficients, stderr : dict
        Those of the last fit where it was added, else of the ranking.
    why : str
        The reason for the verdict, in one line.
    where : dict
        Of unknown structure: from and to of each driver.
    """

    effect: str
    candidates: tuple
    verdict: str
    gain: float
    coefficients: dict
    stderr: dict
    why: str
    where: dict = field(default_factory=dict)
