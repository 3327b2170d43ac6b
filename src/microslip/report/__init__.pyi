from .predicted.result import AmplitudeCurve as AmplitudeCurve
from .predicted.result import HistoryResponse as HistoryResponse
from .predicted.result import Result as Result
from .predicted.result import Study as Study
