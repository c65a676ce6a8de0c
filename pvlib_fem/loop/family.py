"""Hypotheses among which a chance is counted, before the first look."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Family:
    """
    Hypotheses among which a chance is counted: of physics, and of instruments.

    Each has its own, so that one is not seen the less for the other being asked; a
    change of an instrument has the chance of its date before it besides.
    """

    physics: int = 1
    changes: int = 1

    @classmethod
    def counted(cls, effects, rounds=1):
        """Those of some effects, in so many rounds."""
        changes = sum(bool(effect.channel) for effect in effects)
        physics = len(effects) - changes
        return cls(rounds * max(1, physics), rounds * max(1, changes))

    def of(self, effect):
        return self.changes if effect.channel else self.physics
