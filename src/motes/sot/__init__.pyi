"""The public names of this package."""

from .network.family import NetworkFamily as NetworkFamily
from .network.network import Network as Network
from .places import scatter as scatter
from .presets import DESCRIPTIONS as DESCRIPTIONS
