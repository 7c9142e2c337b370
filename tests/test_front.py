"""What stands beside the code for who comes by: citation, issue forms, workflows."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
import yaml  # type: ignore[import-untyped]

import motes

ROOT = Path(__file__).parent.parent
WORKFLOWS = sorted((ROOT / ".github/workflows").glob("*.yml"))
PAPERS = 4


def test_the_citation_is_of_this_version_and_of_all_papers() -> None:
    """The keys that version 1.2.0 of the Citation File Format requires."""
    cited: dict[str, Any] = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert cited["cff-version"] == "1.2.0"
    assert cited["version"] == motes.__version__
    works = [cited, *cited["references"]]
    assert len(works) == 1 + PAPERS
    for work in works:
        assert work["title"]
        assert all(work["authors"])
        assert all(
            each.keys() <= {"name", "family-names", "given-names"} for each in work["authors"]
        )
    assert all(work["type"] == "generic" for work in cited["references"])


@pytest.mark.parametrize("path", WORKFLOWS, ids=lambda path: path.stem)
def test_actions_are_named_by_their_hashes(path: Path) -> None:
    """A tag may be moved to other code."""
    used = re.findall(r"uses: (\S+)", path.read_text(encoding="utf-8"))
    assert used
    for action in used:
        assert re.fullmatch(r"[\w./-]+@[0-9a-f]{40}", action), action


def test_one_action_has_one_hash() -> None:
    text = "".join(path.read_text(encoding="utf-8") for path in WORKFLOWS)
    found = set(re.findall(r"uses: (\S+)@(\S+)", text))
    assert len(found) == len({action for action, _ in found})


def test_issue_forms_ask_for_something() -> None:
    forms = [
        each for each in (ROOT / ".github/ISSUE_TEMPLATE").glob("*.yml") if each.stem != "config"
    ]
    assert len(forms) == 3
    for path in forms:
        form: dict[str, Any] = yaml.safe_load(path.read_text(encoding="utf-8"))
        assert form["name"]
        assert form["description"]
        ids = [field["id"] for field in form["body"]]
        assert len(ids) == len(set(ids)) > 1


def test_pages_for_the_community_link_to_files_that_exist() -> None:
    for name in ("SECURITY.md", "CODE_OF_CONDUCT.md"):
        text = (ROOT / name).read_text(encoding="utf-8")
        for link in re.findall(r"\]\((?!http)([^)#]+)", text):
            assert (ROOT / link).exists(), link
