"""What Griffe does not know of motes' docstrings: fields that share a text, and what has no type.

mkdocstrings loads this as an extension of Griffe (mkdocs.yml).
"""

from __future__ import annotations

from typing import Any

import griffe
from griffe import DocstringAttribute, DocstringSectionAttributes, DocstringSectionParameters


class JointNames(griffe.Extension):
    """Lists the fields of a class with their texts, and gives joint parameters their own types."""

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
        if isinstance(obj, griffe.Class) and (fields := _fields(obj)):
            obj.docstring.parsed.append(DocstringSectionAttributes(fields))


def _fields(kind: griffe.Class) -> list[DocstringAttribute]:
    """Take the texts off the fields of a class, and return these with their types."""
    found, waiting = [], []
    for member in kind.attributes.values():
        if member.has_labels("property") or member.name.startswith("_"):
            continue
        waiting.append(member)
        if (text := member.docstring) is not None:
            found += [
                DocstringAttribute(each.name, annotation=each.annotation, description=text.value)
                for each in waiting
            ]
            member.docstring, waiting = None, []
    return found
