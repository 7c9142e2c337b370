"""The public names of this package."""

from .reader import table_of as table_of
from .schema import FORMS as FORMS, FrameRow as FrameRow, Header as Header, text_name as text_name
