"""The public names of this package."""

from .filtering.scatter import scatter as scatter
from .network.family import NetworkFamily as NetworkFamily
from .network.network import Network as Network
from .presets import DESCRIPTIONS as DESCRIPTIONS
