"""Public names of `pvlib_fem`; each is loaded at its first use."""

from . import (
    datasets as datasets,
    detect as detect,
    drivers as drivers,
    effects as effects,
    fleet as fleet,
    layers as layers,
    paper as paper,
    plotting as plotting,
    power as power,
    scores as scores,
    simulator as simulator,
)
from ._ceiling.ceiling_result import Ceiling as Ceiling
from ._correction.corrected_record import CorrectedRecord as CorrectedRecord
from ._findings import Check as Check, Correction as Correction, Finding as Finding
from ._fit import fit_fem as fit_fem
from ._fitting.fem_fit import FemFit as FemFit
from ._fitting.horizontal import transpose_record as transpose_record
from ._fitting.stand_ins import fill_record as fill_record
from ._loop.close import close_loop as close_loop
from ._loop.criteria import Criteria as Criteria
from ._loop.ranking.rank_effects import rank_effects as rank_effects
from ._loop.results.loop_result import Loop as Loop
from ._modelchain import DynamicCellTemperature as DynamicCellTemperature
from ._record.logger_files import read_file as read_file
from ._record.parquet import (
    ParquetRecord as ParquetRecord,
    open_parquet as open_parquet,
)
from ._recovery.event_recovery import recover_events as recover_events
from ._recovery.recover import recover_effects as recover_effects
from ._recovery.recovery_result import Recovery as Recovery
from ._relaxation import ewm as ewm
from ._sensors.compare_sensors import compare_modules as compare_modules
from ._sensors.module_comparison import ModuleComparison as ModuleComparison
from ._thermal.temperature import (
    fem_temperature as fem_temperature,
    heat_balance as heat_balance,
    wm1 as wm1,
    wm2 as wm2,
)
from ._translation import (
    translate_coefficients as translate_coefficients,
    translation_mismatch as translation_mismatch,
)
from .effects._effect import Effect as Effect, Parameter as Parameter, Terms as Terms
from .paper._compare_models import compare_models as compare_models
from .paper._comparison import Comparison as Comparison
from .quality._screen import (
    Screening as Screening,
    screen_record as screen_record,
)

# old names, until 0.2
compare = compare_models
recover = recover_effects
screen = screen_record
translate = translate_coefficients

__version__: str
