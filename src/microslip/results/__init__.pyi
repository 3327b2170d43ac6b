from .predicted.columns import AmplitudeCurve as AmplitudeCurve
from .predicted.columns import HistoryResponse as HistoryResponse
from .predicted.columns import Limits as Limits
from .predicted.columns import OscillatorCurve as OscillatorCurve
from .predicted.result import Result as Result
from .predicted.run import Study as Study
