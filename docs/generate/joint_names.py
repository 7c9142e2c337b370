"""Griffe gives several names that share one text ("frame, time") the first one's type; mend that.

mkdocstrings loads this as an extension of Griffe (mkdocs.yml).
"""

from __future__ import annotations

from typing import Any

import griffe
from griffe import DocstringSectionAttributes, DocstringSectionParameters


class JointNames(griffe.Extension):
    """Gives each parameter and attribute of a docstring the type and default that it has."""

    def on_object(self, *, obj: griffe.Object, **_: Any) -> None:
        """Mend the docstring of one class or function."""
        if obj.docstring is None or not isinstance(obj, griffe.Class | griffe.Function):
            return
        for section in obj.docstring.parsed:
            if isinstance(section, DocstringSectionParameters):
                for one in section.value:
                    if one.name in obj.parameters:
                        one.annotation = obj.parameters[one.name].annotation
                        one.value = obj.parameters[one.name].default
            elif isinstance(section, DocstringSectionAttributes):
                for each in section.value:
                    if isinstance(known := obj.members.get(each.name), griffe.Attribute):
                        each.annotation = known.annotation
