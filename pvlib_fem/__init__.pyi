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
from .ceiling.result import Ceiling as Ceiling
from .correction.result import CorrectedRecord as CorrectedRecord
from .effects.effect import Effect as Effect, Parameter as Parameter, Terms as Terms
from .findings import Check as Check, Correction as Correction, Finding as Finding
from .fit import fit_fem as fit_fem
from .fitting.horizontal import transpose_record as transpose_record
from .fitting.result import FemFit as FemFit
from .fitting.stand_ins import fill_record as fill_record
from .loop.close import close_loop as close_loop
from .loop.criteria import Criteria as Criteria
from .loop.ranking import rank_effects as rank_effects
from .loop.result import Loop as Loop
from .modelchain import DynamicCellTemperature as DynamicCellTemperature
from .paper.compare import compare_models as compare_models
from .paper.comparison import Comparison as Comparison
from .quality.screen import (
    Screening as Screening,
    screen_record as screen_record,
)
from .record.files import read_file as read_file
from .record.parquet import ParquetRecord as ParquetRecord, open_parquet as open_parquet
from .recovery.events import recover_events as recover_events
from .recovery.recover import recover_effects as recover_effects
from .recovery.result import Recovery as Recovery
from .relaxation import ewm as ewm
from .sensors.compare import compare_modules as compare_modules
from .sensors.result import ModuleComparison as ModuleComparison
from .thermal.temperature import (
    fem_temperature as fem_temperature,
    heat_balance as heat_balance,
    wm1 as wm1,
    wm2 as wm2,
)
from .translation import (
    translate_coefficients as translate_coefficients,
    translation_mismatch as translation_mismatch,
)

# old names, until 0.2
compare = compare_models
recover = recover_effects
screen = screen_record
translate = translate_coefficients

__version__: str
