from .errors import InputError as InputError
from .errors import StudyError as StudyError
from .friction import BackboneLaw as BackboneLaw
from .friction import Interface as Interface
from .friction import PeriodicResponse as PeriodicResponse
from .friction import Sliders as Sliders
from .friction import Verdict as Verdict
from .heights import Discrete as Discrete
from .heights import Exponential as Exponential
from .heights import Gaussian as Gaussian
from .heights import HeightDistribution as HeightDistribution
from .heights import Statistical as Statistical
from .loops import Loop as Loop
from .materials import Material as Material
from .materials import MaterialPair as MaterialPair
from .memory import State as State
from .normal import AsperityPopulation as AsperityPopulation
from .normal import GreenwoodWilliamson as GreenwoodWilliamson
from .normal import NormalLaw as NormalLaw
from .normal import SphereOnFlat as SphereOnFlat
from .normal import TabulatedNormalLaw as TabulatedNormalLaw
from .study import Result as Result
from .study import Study as Study

__version__: str
