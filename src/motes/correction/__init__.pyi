"""The public names of this package."""

from .coordinates import Coordinates as Coordinates
from .correct import passes_over as passes_over
from .gains import ranked as ranked
from .history import History as History
from .join import Stretch as Stretch, shared_variance as shared_variance
from .keyframes import check_keyframes as check_keyframes
from .passes import Course as Course, run_pass as run_pass
