"""docs/gallery.md: its texts and its pictures of terminals are what `make gallery` makes."""

from __future__ import annotations

import html
import importlib
import itertools
import re
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from motes.cli.app import commands
from motes.cli.demo import STORIES
from motes.video.writer import VideoWriter

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT / "docs/generate"))

gallery: Any = importlib.import_module("gallery")
COMMANDS, KINDS = gallery.COMMANDS, gallery.KINDS

NUMBER = re.compile(r"\d[\d.,]*")
MEASURED = ("alike", "fast", "gray", "shrinking", "turning")
"""Kinds of film whose scores are measured: four that take a second, and one whose target differs
from others in the sign of its gradients alone."""


def words(text: str) -> list[str]:
    """Return the words of a text, with # for each number."""
    always = re.sub(r"interpolated in \d+, ", "", text)  # said only of films that have such frames
    return NUMBER.sub("#", always).split()


def test_every_command_has_its_picture() -> None:
    known = {name for name in commands([]) if not name.startswith("-")}
    shown = {command.name for command in COMMANDS} | {"studio"}
    assert shown == known
    assert gallery.command_text() in gallery.PAGE.read_text(encoding="utf-8")


def test_twenty_kinds_of_film_have_pictures_of_their_own() -> None:
    assert len({kind.name for kind in KINDS}) == len(KINDS) >= 20
    assert not {f"{kind.name}.webp" for kind in KINDS} & {command.file for command in COMMANDS}


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_every_kind_of_film_is_on_the_page(kind: Any) -> None:
    page = words(gallery.PAGE.read_text(encoding="utf-8"))
    missed = words(gallery.film_text(kind, gallery.Score(1.0, 1, 1)))
    none = words(gallery.film_text(kind, gallery.Score(1.0, 0, 0)))
    assert any(" ".join(text) in " ".join(page) for text in (missed, none))
    assert (gallery.FOLDER / f"{kind.name}.webp").exists()


@pytest.mark.slow
@pytest.mark.parametrize(
    "kind", [each for each in KINDS if each.name in MEASURED], ids=lambda kind: kind.name
)
def test_what_the_page_says_of_a_film_is_measured(kind: Any) -> None:
    text = gallery.film_text(kind, gallery.followed(kind)[0])
    assert text in gallery.PAGE.read_text(encoding="utf-8"), f"run make gallery: {text}"


@pytest.mark.slow
def test_the_picture_of_the_experts_is_what_they_see() -> None:
    with Image.open(gallery.EXPERTS) as file:
        shown = np.asarray(file.convert("RGB"), float)
    assert np.abs(gallery.picture() - shown).mean() < 4, "run make gallery"


@pytest.mark.slow
def test_terminals_show_what_commands_print(tmp_path: Path) -> None:
    """They are said of whole films; of two dozen frames they say the same in other numbers."""
    pytest.importorskip("cv2")
    (tmp_path / "films").mkdir()
    for story in STORIES[:2]:
        with VideoWriter(tmp_path / "films" / f"{story.name}.mp4", 25) as writer:
            for frame, _ in itertools.islice(story.film(0), 24):
                writer.write(frame.pixels)
    for command in COMMANDS:
        if command.picture is not None and command.name != "track":
            continue
        printed = gallery.printed(command.line, tmp_path)
        if command.picture is not None:
            continue
        picture = (gallery.FOLDER / command.file).read_text(encoding="utf-8")
        shown = html.unescape("\n".join(re.findall(r"<text[^>]*>(.*?)</text>", picture)))
        if command.name == "doctor":  # versions, and which extras there are, are a machine's
            now = f"$ motes doctor\n{printed}"
            assert [row.split()[0] for row in shown.splitlines()] == [
                row.split()[0] for row in now.splitlines()
            ]
        else:
            assert words(shown) == words(f"$ {command.line}\n{printed}")
