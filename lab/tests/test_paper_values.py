"""The table of the presets' values in papers.md is what the presets have."""

import pytest

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
