"""The public names of this package."""

from .reader import table_of as table_of
from .schema import FORMS as FORMS
from .schema import FrameRow as FrameRow
from .schema import Header as Header
from .schema import text_name as text_name
