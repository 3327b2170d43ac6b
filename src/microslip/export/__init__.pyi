from .formats import KINDS as KINDS
from .request import Accuracy as Accuracy
from .writing import Exported as Exported
from .writing import write as write
