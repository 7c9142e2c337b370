"""The public names of this package."""

from .decoder import TITLE_OPTIONS as TITLE_OPTIONS
from .film import (
    DamagedError as DamagedError,
    Film as Film,
    FrameReader as FrameReader,
    fits as fits,
    shared as shared,
)
from .image_files import IMAGE_ENDINGS as IMAGE_ENDINGS
from .newest import Newest as Newest
from .reconnect import pauses as pauses
from .seeker import Seeker as Seeker
from .sources import (
    check_rate as check_rate,
    is_playlist as is_playlist,
    is_recorded as is_recorded,
    is_remote as is_remote,
)
