"""Links between the site of motes and that of its lab, which is in lab/ beside it.

In the repository they are links between docs/ and lab/docs/. mkdocs calls the functions named
`on_...` as hooks of both sites (mkdocs.yml, lab/mkdocs.yml).
"""

from __future__ import annotations

import logging
import re
from pathlib import Path

from markdown.extensions.toc import slugify
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.nav import Link, Navigation
from mkdocs.structure.pages import Page

LOG = logging.getLogger("mkdocs.hooks.two_sites")
ROOT = Path(__file__).parents[2]
LINK = re.compile(
    r"\]\((?P<up>(?:\.\./)*)\.\./(?P<room>lab/docs|docs)/(?P<name>[\w/-]+)\.md"
    r"(?P<anchor>#[\w-]+)?\)"
)
ELSEWHERE = "elsewhere:"
"""What stands before such a link until mkdocs has checked those of its own site."""
NARROWER = {"76.25em": "70em", "76.234375em": "69.984375em"}
"""The widths at which the theme puts its navigation beside the page, and narrower ones."""


def anchors(text: str) -> set[str]:
    """Return the anchors of a page's headings."""
    heads = re.findall(r"^#+ (.+)$", re.sub(r"^```.*?^```", "", text, flags=re.M | re.S), re.M)
    plain = (re.sub(r"\[(.*?)\]\(.*?\)|[`*]", r"\1", head) for head in heads)
    return {slugify(head, "-") for head in plain}


def broken(room: str, name: str, anchor: str) -> bool:
    """Whether there is no such page or heading; pages made from the code are not looked into."""
    path = ROOT / room / f"{name}.md"
    if room == "docs" and name.startswith("reference/"):
        return False
    return not path.exists() or bool(
        anchor and anchor not in anchors(path.read_text(encoding="utf-8"))
    )


def on_nav(nav: Navigation, config: MkDocsConfig, **_: object) -> Navigation:
    """Add the other site to the navigation."""
    lab = Path(config.docs_dir) == ROOT / "lab" / "docs"
    nav.items.append(Link("motes", "../index.html") if lab else Link("The lab", "lab/index.html"))
    return nav


def on_page_markdown(text: str, page: Page, **_: object) -> str:
    """Make the links to the other site those of the built pages; warn of broken ones."""

    def built(link: re.Match[str]) -> str:
        up, room, name, anchor = link["up"], link["room"], link["name"], link["anchor"] or ""
        if broken(room, name, anchor[1:]):
            here = page.file.src_uri
            LOG.warning("%s links to %s/%s%s, which is not there", here, room, name, anchor)
        return f"]({ELSEWHERE}{up}{'lab/' if room == 'lab/docs' else ''}{name}.html{anchor})"

    return LINK.sub(built, text)


def on_page_content(html: str, **_: object) -> str:
    """Let go of the mark."""
    return html.replace(f'href="{ELSEWHERE}', 'href="')


def on_post_build(config: MkDocsConfig) -> None:
    """Show the navigation beside the page from 1120 pixels on; the theme has it from 1220 on."""
    assets = Path(config.site_dir) / "assets"
    changed = 0
    for path in [*assets.glob("stylesheets/*.css"), *assets.glob("javascripts/bundle.*.js")]:
        text = path.read_text(encoding="utf-8")
        for old, new in NARROWER.items():
            changed += text.count(old)
            text = text.replace(old, new)
        path.write_text(text, encoding="utf-8")
    if not changed:
        raise ValueError("the theme has other widths than docs/generate/two_sites.py knows")
