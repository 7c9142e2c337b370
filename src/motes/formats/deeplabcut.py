"""DeepLabCut's CSV, which `movement` and other tools for the behavior of animals read.

Each object has three points: its center, and the ends of its ellipse's half-axes a and b. So the
whole ellipse is there, and tools have the object's orientation. The likelihood is the confidence.
It is not read: points alone have no size.
https://deeplabcut.github.io/DeepLabCut/docs/standardDeepLabCut_UserGuide.html
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from motes.core.track import Track
from motes.formats.recording import Recording
from motes.formats.visibility import check_identities, visible

POINTS = ("center", "axis_a", "axis_b")
NAME = "object_"
"""Prefix of the name of an individual; the identity follows."""
VALUES = ("x", "y", "likelihood")


def write(recorded: Recording) -> Iterator[bytes]:
    """Yield four rows of titles (three if there is one object), then a row for each frame.

    So have frames that nobody has looked at: tools take the place of a row for its frame.
    """
    identities = sorted({each.identity for row in recorded for each in visible(row)})
    check_identities(identities, "DeepLabCut")
    columns = [
        (identity, point, value) for identity in identities for point in POINTS for value in VALUES
    ]
    titles = [("scorer", ["motes"] * len(columns))]
    if len(identities) > 1:
        titles.append(("individuals", [f"{NAME}{each}" for each, _, _ in columns]))
    titles.append(("bodyparts", [point for _, point, _ in columns]))
    titles.append(("coords", [value for _, _, value in columns]))
    for title, values in titles:
        yield ",".join([title, *values]).encode() + b"\n"
    rows = {row.frame: row for row in recorded}
    for frame in range(max([recorded.length, *(frame + 1 for frame in rows)])):
        here = {each.identity: each for each in visible(rows[frame])} if frame in rows else {}
        fields = [field for identity in identities for field in _fields(here.get(identity))]
        yield ",".join([str(frame), *fields]).encode() + b"\n"


def _fields(each: Track | None) -> list[str]:
    if each is None:
        return ["NaN"] * len(POINTS) * len(VALUES)  # of empty fields pandas makes titles
    x, y, a, b, theta = each.ellipse
    cos, sin = math.cos(theta), math.sin(theta)
    points = (x, y), (x + a * cos, y + a * sin), (x - b * sin, y + b * cos)
    return [
        field for u, v in points for field in (f"{u:.3f}", f"{v:.3f}", f"{each.confidence:.5f}")
    ]
