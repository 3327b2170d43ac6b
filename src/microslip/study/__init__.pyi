from .result import AmplitudeCurve as AmplitudeCurve
from .result import HistoryResponse as HistoryResponse
from .result import Limits as Limits
from .result import OscillatorCurve as OscillatorCurve
from .result import Result as Result
from .schema import Study as Study
