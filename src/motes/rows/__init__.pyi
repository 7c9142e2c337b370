"""The public names of this package."""

from .journal import FrameRow as FrameRow
from .journal import Header as Header
from .journal import ObjectRow as ObjectRow
from .journal import object_rows as object_rows
from .journal import text_name as text_name
from .reader import table_of as table_of
from .schema import CAMERA as CAMERA
from .schema import ELLIPSE as ELLIPSE
from .schema import FORMS as FORMS
from .schema import hindsight as hindsight
from .writer import JournalWriter as JournalWriter
