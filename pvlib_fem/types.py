"""What public functions take, where more than one type goes."""

from collections.abc import Sequence
from os import PathLike

import numpy as np
import pandas as pd

#: a number, or a column of them
Numeric = float | np.ndarray | pd.Series
#: which rows are meant, True where they are
Rows = bool | np.ndarray | pd.Series
#: times of arrays: datetimes, or numbers [s]
Times = pd.DatetimeIndex | np.ndarray | Sequence[float] | None
FilePath = str | PathLike[str]
