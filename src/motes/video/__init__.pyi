"""The public names of this package."""

from .film import DamagedError as DamagedError
from .film import Film as Film
from .film import FrameReader as FrameReader
from .film import fits as fits
from .film import shared as shared
from .image_files import IMAGE_ENDINGS as IMAGE_ENDINGS
from .newest import Newest as Newest
from .reconnect import pauses as pauses
from .seeker import Seeker as Seeker
from .sources import check_rate as check_rate
from .sources import is_playlist as is_playlist
from .sources import is_recorded as is_recorded
from .sources import is_remote as is_remote
