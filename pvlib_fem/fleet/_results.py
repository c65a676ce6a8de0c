"""Read a folder of results."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from pvlib_fem.fleet._store import result_path
from pvlib_fem.fleet._tasks import TASKS

STATES = ("done", "failed", "not run")


@dataclass(frozen=True)
class Results:
    """
    A folder of results; ``print(results)`` counts them.

    Attributes
    ----------
    out : Path
    """

    out: Path

    def table(self, name: str, json: bool = False) -> pd.DataFrame:
        """Table ``systems``, ``coefficients`` or ``findings``, with or without JSON."""
        import pyarrow.parquet as pq

        path = Path(self.out, f"{name}.parquet")
        if not path.exists():
            raise ValueError(f"{self.out} holds no results: there is no {path.name}")
        names = pq.read_schema(path).names
        columns = [column for column in names if json or column != "json"]
        return pd.read_parquet(path, columns=columns)

    @property
    def systems(self) -> pd.DataFrame:
        """A row for each system."""
        return self.table("systems")

    @property
    def coefficients(self) -> pd.DataFrame:
        """A row for each coefficient of each system."""
        return self.table("coefficients")

    @property
    def findings(self) -> pd.DataFrame:
        """A row for each finding of each system."""
        return self.table("findings")

    def result(self, identity: str) -> Any:
        """The result of a system: a fit, a loop or a recovery."""
        path = result_path(self.out, identity)
        if not path.exists():
            raise ValueError(f"{self.out} holds nothing of a system {identity!r}")
        head = json.loads(path.read_text(encoding="utf-8"))["fleet"]
        if head["state"] != "done":
            raise ValueError(f"system {identity} failed: {head['message']}")
        return TASKS[head["task"]].result.from_json(path)

    def __str__(self) -> str:
        states = self.systems["state"].value_counts()
        counts = ", ".join(f"{states[s]:,} {s}" for s in STATES if states.get(s))
        return f"pvlib_fem: {states.sum():,} systems: {counts}; in {self.out}"
