from .predicted.result import Result as Result
from .predicted.result import Study as Study
