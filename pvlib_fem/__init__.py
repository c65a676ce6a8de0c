"""The temperature of photovoltaic modules, second by second, for pvlib users."""

from pvlib_fem import (
    datasets,
    drivers,
    effects,
    fleet,
    layers,
    paper,
    plotting,
    scores,
    simulator,
)
from pvlib_fem.effects.effect import Effect, Parameter, Terms
from pvlib_fem.findings import Check, Correction, Finding
from pvlib_fem.fitting.compare import compare
from pvlib_fem.fitting.comparison import Comparison
from pvlib_fem.fitting.fit import fit_fem
from pvlib_fem.fitting.result import FemFit
from pvlib_fem.loop.close import close_loop
from pvlib_fem.loop.criteria import Criteria
from pvlib_fem.loop.modules import compare_modules
from pvlib_fem.loop.ranking import rank_effects
from pvlib_fem.loop.result import Loop
from pvlib_fem.modelchain import DynamicCellTemperature
from pvlib_fem.quality.screen import Screening, screen
from pvlib_fem.record.files import read_file
from pvlib_fem.record.parquet import ParquetRecord, open_parquet
from pvlib_fem.recovery.recover import recover
from pvlib_fem.recovery.result import Recovery
from pvlib_fem.relaxation import ewm
from pvlib_fem.thermal.temperature import fem_temperature, heat_balance, wm1, wm2
from pvlib_fem.translate import translate, translation_mismatch

__version__ = "0.1.0"

__all__ = [
    "Check",
    "Comparison",
    "Correction",
    "Criteria",
    "DynamicCellTemperature",
    "Effect",
    "FemFit",
    "Finding",
    "Loop",
    "Parameter",
    "ParquetRecord",
    "Recovery",
    "Screening",
    "Terms",
    "close_loop",
    "compare",
    "compare_modules",
    "datasets",
    "drivers",
    "effects",
    "ewm",
    "fem_temperature",
    "fit_fem",
    "fleet",
    "heat_balance",
    "layers",
    "open_parquet",
    "paper",
    "plotting",
    "rank_effects",
    "read_file",
    "recover",
    "scores",
    "screen",
    "simulator",
    "translate",
    "translation_mismatch",
    "wm1",
    "wm2",
]
