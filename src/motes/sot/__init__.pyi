"""The public names of this package."""

from .known_target import scatter as scatter
from .network.network import Network as Network, NetworkFamily as NetworkFamily
from .presets import DESCRIPTIONS as DESCRIPTIONS
