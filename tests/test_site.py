"""The documentation site: it is built strictly, and needs nothing from elsewhere."""

import re
import subprocess
import sys
import tomllib
from html.parser import HTMLParser
from pathlib import Path

import pytest

from motes import Discriminative, MeanShift, ParticleFilter, configure, preset
from motes.core.config_keys import all_keys, keys
from motes.mot.scene_config import WatchConfig
from pages import blocks

ROOT = Path(__file__).parent.parent
KINDS = ParticleFilter, Discriminative, MeanShift, WatchConfig
PAGES = [ROOT / "README.md", *(ROOT / "docs").rglob("*.md"), *(ROOT / "lab/docs").rglob("*.md")]
WITHOUT_PICTURE = {"api", "architecture", "gallery"}
"""Pages about code, and one that is pictures below its first heading."""
CALLED = {"motion.propagate", "motion.ellipses", "likelihood.log", "fusion.fuse"}
"""Methods, not keys."""
LOADED = {"script", "img", "iframe", "source", "video", "audio", "embed", "object", "link"}
"""Elements of which a browser loads what they name; of links, the canonical address is none."""


class Page(HTMLParser):
    """Collects what a browser loads for a page, and its classes."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.loaded: list[str] = []
        self.classes: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Take one element of the page."""
        named = {name: value or "" for name, value in attrs}
        self.classes.update(named.get("class", "").split())
        if tag in LOADED and named.get("rel") != "canonical":
            found = (named.get(name, "") for name in ("src", "href", "data", "poster", "srcset"))
            self.loaded += filter(None, found)


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build both sites; a warning, such as of a broken link or heading, fails the build."""
    pytest.importorskip("mkdocs", reason="the site needs: pip install 'motes[docs]'")
    folder = tmp_path_factory.mktemp("site")
    for config, out in (("mkdocs.yml", folder), ("lab/mkdocs.yml", folder / "lab")):
        command = [sys.executable, "-m", "mkdocs", "build", "-f", config, "--site-dir", str(out)]
        run = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
        assert run.returncode == 0, run.stderr
    return folder


@pytest.mark.slow
def test_pages_load_nothing_from_other_hosts(site: Path) -> None:
    pages = list(site.rglob("*.html"))
    assert len(pages) > 15
    for path in pages:
        page = Page(path.read_text(encoding="utf-8"))
        foreign = [url for url in page.loaded if re.match(r"(\w+:)?//", url)]
        assert not foreign, (path, foreign)
        # For these alone the theme's script would ask unpkg.com and api.github.com.
        assert not page.classes & {"mermaid", "md-source"}, path
    for style in site.rglob("*.css"):
        text = style.read_text(encoding="utf-8")
        assert not re.search(r"(@import\s*|url\()[\"']?(https?:)?//", text), style


@pytest.mark.slow
def test_the_page_of_commands_does_not_depend_on_how_the_site_is_built(site: Path) -> None:
    text = (site / "reference" / "cli.html").read_text(encoding="utf-8")
    assert "motes network get [OPTIONS] NAME" in text
    assert "-m mkdocs" not in text


@pytest.mark.slow
def test_links_between_the_two_sites_hold(site: Path) -> None:
    found = 0
    for path in site.rglob("*.html"):
        text = path.read_text(encoding="utf-8")
        assert "elsewhere:" not in text, path
        if path.name == "404.html":  # its addresses are those of a server
            continue
        for name in re.findall(r'href="([\w./-]+\.html)[#"]', text):
            target = (path.parent / name).resolve()
            assert target.exists(), (path, name)
            found += ("lab" in target.parts) != ("lab" in path.parts)
    assert found > 50


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_pages_link_to_files_of_the_repository(page: Path) -> None:
    """Who reads them there has no site with generated pages."""
    text = page.read_text(encoding="utf-8")
    for link in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", text):
        assert (page.parent / link).exists(), link


def test_pages_open_with_a_picture() -> None:
    for page in (ROOT / "docs").rglob("*.md"):
        opening = page.read_text(encoding="utf-8").partition("\n## ")[0]
        assert "![" in opening or page.stem in WITHOUT_PICTURE, page


def test_named_configuration_keys_exist() -> None:
    paths = {key.path for kind in KINDS for key in all_keys(keys(kind))}
    tables = {path.rpartition(".")[0] for path in paths}
    roots = {path.partition(".")[0] for path in paths}
    found = 0
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        for name in re.findall(r"`(?:--)?([a-z_]+(?:\.[a-z_-]+)+)(?: [^`]*)?`", text):
            key = name.replace("-", "_")
            if key.partition(".")[0] in roots and not key.endswith(".py"):
                assert key in paths | tables | CALLED, (page, name)
                found += 1
    assert found > 50


def test_configurations_can_be_loaded() -> None:
    found = 0
    for page in PAGES:
        for block in blocks(page):
            if block.language == "toml" and block.text.startswith("preset"):
                found += 1
                values = tomllib.loads(block.text)
                configure(preset(values.pop("preset")), values)
    assert found
