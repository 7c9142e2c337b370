"""The pages of the site that are not in docs/, but made from the code.

mkdocs calls `on_files` as a hook (mkdocs.yml).
"""

from __future__ import annotations

import importlib
import sys
from collections import defaultdict
from collections.abc import Iterable, Iterator
from unittest.mock import patch

import griffe
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

import motes
from motes.cli.app import commands
from motes.cli.exit_codes import EXIT_CODES
from motes.core.config_keys import Key, keys, summary
from motes.mot.scene_config import WatchConfig
from motes.sot.discriminative.tracker import Discriminative
from motes.sot.mean_shift import MeanShift
from motes.sot.particle_filter import ParticleFilter
from motes.sot.presets import DESCRIPTIONS
from motes_lab.cli.app import app as lab_app

MODULES = ("cues", "filtering", "synthetic", "testing")
"""The public modules beside `motes` itself."""
PACKAGES = {
    "sot": "One object",
    "mot": "Many objects",
    "video": "Sources and writers of frames",
    "correction": "Corrected tracks",
    "rows": "Rows",
    "output": "Drawings",
    "core": "Frames, results and errors",
}
"""Headings of the API page by the package that a name comes from, in order."""
ROOTS = {
    "Particle filters": ParticleFilter,
    "The default tracker": Discriminative,
    "Mean shift": MeanShift,
    "Scenes of many objects": WatchConfig,
}
"""Headings of the configuration page, and the types that users configure."""

API_HEAD = """\
# Python API

The public names, made from their docstrings; [an overview](../api.md) has examples. Everything else
in the package is internal and may change.

"""
CLI_HEAD = """\
# Commands

The help of every command, made from the programs. `motes COMMAND --help` prints the same.

"""
CONFIGURATION_HEAD = """\
# Configuration keys

Every key that a configuration may have, made from the types that check it. `motes config
PRESET` prints the same, with the values of a preset.

- `motes track --config FILE` reads a [particle filter](#particle-filters), the
  [default tracker](#the-default-tracker) or [mean shift](#mean-shift).
- `motes watch --config FILE` reads a [scene](#scenes-of-many-objects).
- Every key is also an option: `--set motion.noise.position=0.6`.
- Where several tables may stand, `type` chooses one, as in `motion.type = "random_walk"`.
- `--dump-config` prints all keys and values as such a file.

## Presets

"""


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the generated pages to those that were found in docs/."""
    pages = {"api": api_page, "cli": cli_page, "configuration": configuration_page}
    for name, page in pages.items():
        files.append(File.generated(config, f"reference/{name}.md", content=page()))
    return files


def api_page() -> str:
    """Return the page of public names, for mkdocstrings, by the package they come from."""
    names: dict[str, list[str]] = defaultdict(list)
    members = griffe.load("motes", submodules=False).members
    for name in sorted(set(motes.__all__).difference(MODULES)):
        member = members[name]
        assert isinstance(member, griffe.Alias)
        names[member.target_path.split(".")[1]].append(name)
    if unknown := set(names) - set(PACKAGES):
        raise KeyError(f"docs/generate/site_pages.py has no heading for names of {unknown}")
    parts = [API_HEAD]
    for package, heading in PACKAGES.items():
        parts += [f"## {heading}\n"] + [f"::: motes.{name}\n" for name in names[package]]
    for module in MODULES:
        public = importlib.import_module(f"motes.{module}").__all__
        parts += [f"## motes.{module}\n"] + [f"::: motes.{module}.{name}\n" for name in public]
    return "\n".join(parts)


def cli_page() -> str:
    """Return what cyclopts writes about the commands, as a page of the site."""
    # Subcommands show the name of the process, of which only the first word is then replaced.
    with patch.object(sys, "argv", ["motes"]):
        texts = [
            (each.name[0], each.generate_docs(recursive=True, heading_level=1))
            for each in (commands([]), lab_app)
        ]
    # The page has its own head and contents.
    motes, lab = (text.partition(f"\n## {name} ") for name, text in texts)
    codes = EXIT_CODES.partition("\n")[2]
    return (
        f"{CLI_HEAD}## motes {motes[2]}\n## motes-lab {lab[2]}\n"
        f"## Exit codes\n\n```text\n{codes}```\n"
    )


def configuration_page() -> str:
    """Return tables of the presets and of all keys, as `motes config` lists them."""
    parts = [CONFIGURATION_HEAD, "| preset | tracker |", "|---|---|"]
    parts += [f"| `{name}` | {text} |" for name, text in DESCRIPTIONS.items()]
    for title, kind in ROOTS.items():
        parts += [f"\n## {title}\n", f"{summary(kind)}\n", *_tables(keys(kind), 3)]
    return "\n".join([*parts, ""])


def _tables(listed: Iterable[Key], level: int) -> Iterator[str]:
    """Yield a table of the keys that take values, and headings and tables of the others."""
    values = [key for key in listed if not key.choices]
    if values:
        yield "| key | value | default | meaning |\n|---|---|---|---|"
    for key in values:
        unset = "required" if key.required else "not set"
        default = unset if key.value is None else f"`{key.value}`"
        yield f"| `{key.path}` | {_cell(key.type)} | {default} | {_cell(key.meaning)} |"
    for key in listed:
        for choice in key.choices:
            name = key.path if choice.tag is None else f'{key.path}.type = "{choice.tag}"'
            default = " The default." if choice.chosen and choice.tag is not None else ""
            yield f"\n{'#' * level} `{name}`\n"
            if choice.tag is None or choice is key.choices[0]:
                yield f"{key.meaning}\n"
            yield f"{choice.meaning}{default}\n"
            yield from _tables(choice.keys, min(level + 1, 6))


def _cell(text: str) -> str:
    return text.replace("|", "\\|")
