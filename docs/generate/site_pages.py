"""The pages of the site that are made from the code: the API, the commands, the configuration.

mkdocs calls `on_files` as a hook (mkdocs.yml).
"""

from __future__ import annotations

import functools
import re
from collections import defaultdict
from typing import Any

import griffe
import msgspec.inspect as shape
from griffe import Docstring, DocstringSectionAttributes, Parser
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

import motes
from motes.cli.app import app
from motes.core.config import Config
from motes.core.config_keys import alternatives, fields
from motes.mot.pipeline_config import WatchConfig
from motes.sot.discriminative.tracker import Discriminative
from motes.sot.mean_shift import MeanShift
from motes.sot.particle_filter import ParticleFilter

PACKAGES = {
    "sot": "One object",
    "mot": "Many objects",
    "video": "Sources of frames",
    "core": "Frames, results and errors",
}
"""Headings of the API page by the package that a name comes from, in order."""
ROOTS = (ParticleFilter, Discriminative, MeanShift, WatchConfig)
"""Configurations that users name: three kinds of trackers, and what `motes watch` takes."""

API_HEAD = """\
# Python API

The public names of `motes`, made from their docstrings. Everything else in the package is internal
and may change, but for `motes.evaluation.synthetic` (rendered films with truth) and
`motes.video.writer.VideoWriter`, which the tutorials use.

"""
CLI_HEAD = """\
# Commands

The help of every command, made from the program. `motes COMMAND --help` prints the same.

"""
CONFIGURATION_HEAD = """\
# Configuration keys

Every table and key that a configuration may have, made from the types that check it.

- `motes track --config FILE` reads a [particle filter](#particlefilter), the
  [default tracker](#discriminative) or [mean shift](#meanshift).
- `motes watch --config FILE` reads a [scene](#watchconfig).
- A key of a table inside a table has a dot: `motion.noise.position`. On the command line it is an
  option, `--motion.noise.position 0.6`.
- Where several tables may stand, `type` chooses one, as in `motion.type = "random_walk"`.
- `--dump-config` prints all keys with the values of a preset.

"""


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the generated pages to those that were found in docs/."""
    pages = {"api": api_page, "cli": cli_page, "configuration": configuration_page}
    for name, page in pages.items():
        files.append(File.generated(config, f"reference/{name}.md", content=page()))
    return files


@functools.cache
def _package() -> griffe.Module:
    loaded = griffe.load("motes", docstring_parser=Parser.numpy)
    assert isinstance(loaded, griffe.Module)
    return loaded


def api_page() -> str:
    """Return the page of public names, for mkdocstrings, by the package they come from."""
    names: dict[str, list[str]] = defaultdict(list)
    for name in motes.__all__:
        member = _package().members[name]
        assert isinstance(member, griffe.Alias)
        names[member.target_path.split(".")[1]].append(name)
    if unknown := set(names) - set(PACKAGES):
        raise KeyError(f"docs/generate/site_pages.py has no heading for names of {unknown}")
    parts = [API_HEAD]
    for package, heading in PACKAGES.items():
        parts += [f"## {heading}\n"] + [f"::: motes.{name}\n" for name in names[package]]
    return "\n".join(parts)


def cli_page() -> str:
    """Return what cyclopts writes about the commands, as a page of the site."""
    text = app.generate_docs(recursive=True, heading_level=1)
    _, _, commands = text.partition("\n## motes ")  # the page has its own head and contents
    return CLI_HEAD + "## motes " + commands


def configuration_page() -> str:
    """Return tables of all configuration types that can be reached from `ROOTS`."""
    kinds: list[type[Config]] = []
    for root in ROOTS:
        _collect(root, kinds)
    return CONFIGURATION_HEAD + "\n".join(_section(kind) for kind in kinds)


def _collect(kind: type[Config], kinds: list[type[Config]]) -> None:
    """Append a configuration type and all inside it to `kinds`, each once, outer ones first."""
    if kind in kinds:
        return
    kinds.append(kind)
    for field in fields(kind):
        for inner in _structs(shape.type_info(field.type)):
            _collect(inner, kinds)


def _structs(info: shape.Type) -> list[type[Config]]:
    """Return the configuration types that a type is made of."""
    if isinstance(info, shape.StructType | shape.CustomType):  # the latter are interfaces
        return [each for each in alternatives(info.cls) if issubclass(each, Config)]
    parts = [getattr(info, name, ()) for name in ("types", "item_types")]
    parts.append(
        [getattr(info, name) for name in ("item_type", "value_type") if hasattr(info, name)]
    )
    return [struct for part in parts for inner in part for struct in _structs(inner)]


def _section(kind: type[Config]) -> str:
    """Return the heading, the first line of the docstring, and the keys of a configuration."""
    described = _package()[f"{kind.__module__}.{kind.__qualname__}".removeprefix("motes.")]
    assert isinstance(described, griffe.Class)
    meanings = _meanings(described)
    tag = kind.__struct_config__.tag
    lines = [f"## {kind.__name__}\n"]
    if tag is not None:
        lines.append(f'`type = "{tag}"`\n')
    lines.append(_text(described.docstring).split("\n\n")[0] + "\n")
    if fields(kind):
        lines += ["| key | value | default | meaning |", "|---|---|---|---|"]
    for field in fields(kind):
        value = _value(shape.type_info(field.type))
        meaning = meanings.get(field.name, "")
        lines.append(f"| `{field.name}` | {value} | {_default(field)} | {meaning} |")
    return "\n".join([*lines, ""])


def _text(docstring: Docstring | None) -> str:
    return "" if docstring is None else docstring.value


def _meanings(described: griffe.Class) -> dict[str, str]:
    """Return what the docstrings of a class and its bases say of each attribute."""
    meanings: dict[str, str] = {}
    for part in (*reversed(described.mro()), described):
        for section in part.docstring.parsed if part.docstring else ():
            if isinstance(section, DocstringSectionAttributes):
                for one in section.value:  # numpy's style has several names before one text
                    meanings |= dict.fromkeys(one.name.split(", "), _cell(one.description))
    return meanings


def _cell(text: str) -> str:
    return re.sub(r"\s+", " ", text).replace("|", "\\|")


def _default(field: Any) -> str:
    """Return the default of a field as it would be written in TOML."""
    value = field.default
    if isinstance(value, Config):
        tag = value.__struct_config__.tag
        return f'`type = "{tag}"`' if tag is not None else "as below"
    if value is None:
        return "none"
    if isinstance(value, tuple):
        return f"`{list(value)}`"
    if isinstance(value, bool):
        return f"`{str(value).lower()}`"
    return f'`"{value}"`' if isinstance(value, str) else f"`{value}`"


def _number(bound: float) -> str:
    return f"{bound:,}" if isinstance(bound, int) else f"{bound:g}"


def _value(info: shape.Type) -> str:
    """Return in words what a type accepts."""
    match info:
        case shape.StructType(cls=cls):
            return f"[{cls.__name__}](#{cls.__name__.lower()})"
        case shape.CustomType(cls=cls):
            links = (f"[{each.__name__}](#{each.__name__.lower()})" for each in alternatives(cls))
            return " or ".join(links)
        case shape.UnionType(types=types):
            return " or ".join(_value(one) for one in types)
        case shape.LiteralType(values=values):
            return ", ".join(f'`"{one}"`' for one in values)
        case shape.FloatType() | shape.IntType():
            word = "number" if isinstance(info, shape.FloatType) else "whole number"
            signs = (">", info.gt), ("≥", info.ge), ("<", info.lt), ("≤", info.le)
            return " ".join(
                [word, ", ".join(f"{s} {_number(b)}" for s, b in signs if b is not None)]
            )
        case shape.TupleType(item_types=items):
            return f"list of {len(items)}: {_value(items[0])}"
        case shape.VarTupleType(item_type=item) | shape.ListType(item_type=item):
            return f"list of {_value(item)}"
        case shape.DictType(value_type=value):
            return f"table of {_value(value)}"
        case shape.BoolType():
            return "`true` or `false`"
        case shape.StrType():
            return "text"
        case shape.NoneType():
            return "none"
    raise TypeError(f"docs/generate/site_pages.py has no words for {info}")
