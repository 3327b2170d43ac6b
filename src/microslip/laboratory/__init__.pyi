from .campaign import Campaign as Campaign
from .conditioning import condition as condition
from .estimates import Estimate as Estimate
from .measurement import Measurement as Measurement
from .measurement import measure as measure
from .record import Record as Record
from .virtual import VirtualTribometer as VirtualTribometer
