"""The table of the presets' values in papers.md is what the presets have."""

from __future__ import annotations

import pytest

from motes import PRESETS
from scripts import script

values = script("docs/generate/paper_values.py")


def test_the_page_has_the_values_of_the_presets() -> None:
    """If not: python docs/generate/paper_values.py."""
    text = values.PAGE.read_text(encoding="utf-8")
    assert text.partition(values.START)[2].partition(values.END)[0] == values.generated()


@pytest.mark.parametrize("name", values.VALUES)
def test_the_printed_preset_has_every_value_that_its_paper_prints(name: str) -> None:
    for each in values.VALUES[name]:
        found = values.value_of(f"{name}:printed", each.key)
        if each.paper == values.OPEN:
            assert found is not None, each
        else:
            assert found == each.meant, each


def test_what_differs_is_bold() -> None:
    rows = [line.split(" | ") for line in values.table().splitlines()]
    [margin] = [row for row in rows if "`presence.margin`" in row]
    assert margin[-2:] == ["0", "**0.7** |"]
    [sigma] = [row for row in rows if row[1:3] == ["N 10", "not given"]]
    assert sigma[-2:] == ["0.1", "0.1 |"]
    assert not [row for row in rows if row[1:3] == ["ZP 4", "400"]]  # as printed
    assert values.as_text({"type": "every_pixel"}) == "every pixel"
    assert [values.as_text(each) for each in (None, True, 0.5)] == ["–", "yes", "0.5"]


def test_watch_follows_by_another_preset() -> None:
    assert "`nummiaro:adaptive`: 100 samples and color alone" in values.watched()
    assert list(PRESETS["nummiaro:adaptive"].cues) == ["color"]
