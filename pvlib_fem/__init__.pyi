"""What `import pvlib_fem` has; each is loaded when it is first asked for."""

from . import (
    datasets as datasets,
)
from . import (
    drivers as drivers,
)
from . import (
    effects as effects,
)
from . import (
    fleet as fleet,
)
from . import (
    layers as layers,
)
from . import (
    paper as paper,
)
from . import (
    plotting as plotting,
)
from . import (
    scores as scores,
)
from . import (
    simulator as simulator,
)
from .effects.effect import Effect as Effect
from .effects.effect import Parameter as Parameter
from .effects.effect import Terms as Terms
from .findings import Check as Check
from .findings import Correction as Correction
from .findings import Finding as Finding
from .fitting.compare import compare as compare
from .fitting.comparison import Comparison as Comparison
from .fitting.fit import fit_fem as fit_fem
from .fitting.result import FemFit as FemFit
from .loop.close import close_loop as close_loop
from .loop.criteria import Criteria as Criteria
from .loop.modules import compare_modules as compare_modules
from .loop.ranking import rank_effects as rank_effects
from .loop.result import Loop as Loop
from .modelchain import DynamicCellTemperature as DynamicCellTemperature
from .quality.screen import Screening as Screening
from .quality.screen import screen as screen
from .record.files import read_file as read_file
from .record.parquet import ParquetRecord as ParquetRecord
from .record.parquet import open_parquet as open_parquet
from .recovery.recover import recover as recover
from .recovery.result import Recovery as Recovery
from .relaxation import ewm as ewm
from .thermal.temperature import (
    fem_temperature as fem_temperature,
)
from .thermal.temperature import (
    heat_balance as heat_balance,
)
from .thermal.temperature import (
    wm1 as wm1,
)
from .thermal.temperature import (
    wm2 as wm2,
)
from .translation import (
    translate as translate,
)
from .translation import (
    translation_mismatch as translation_mismatch,
)

__version__: str
