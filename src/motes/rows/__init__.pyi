"""The public names of this package."""

from .journal import FrameRow as FrameRow
from .journal import Header as Header
from .journal import text_name as text_name
from .reader import table_of as table_of
from .schema import FORMS as FORMS
