from .modal_curve import ModalCurve as ModalCurve
from .oscillator import Decay as Decay
from .oscillator import Oscillator as Oscillator
from .preload import Preload as Preload
from .ring_down import RingDown as RingDown
from .structure import Structure as Structure
