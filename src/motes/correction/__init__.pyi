"""The public names of this package."""

from . import join as join
from .coordinates import Coordinates as Coordinates
from .correct import correct_stretch as correct_stretch
from .correct import stretches as stretches
from .correct import tracks_of as tracks_of
from .doubts import ranked as ranked
from .history import History as History
from .keyframes import Keyframes as Keyframes
from .keyframes import check_keyframes as check_keyframes
from .passes import Course as Course
from .passes import run_pass as run_pass
