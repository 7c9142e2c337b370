"""`motes network`: get trained networks that join the tracker."""

from __future__ import annotations

import sys
from typing import Annotated

from cyclopts import App

from motes.cli.exit_codes import DONE
from motes.cli.option_groups import FLAG
from motes.cli.streams import log
from motes.core.errors import ConfigError
from motes.sot.network.published import (
    PUBLISHED,
    PublishedNetwork,
    fetch,
    folder_of,
    is_whole,
    published,
)

app = App(
    name="network",
    help="Get trained networks that join the tracker. None comes with motes.",
    help_format="plaintext",
)


@app.command
def get(name: str, /, *, yes: Annotated[bool, FLAG] = False) -> int:
    """Download a network from its publisher, for --network NAME from then on.

    It says who publishes the files and what may be done with them, and asks. Their sizes and
    digests (SHA-256) must be those that motes knows.

    Parameters
    ----------
    name
        The network; motes network list has all.
    yes
        Do not ask.
    """
    network = published(name)
    if is_whole(name):
        log(f"{name} is here already: {folder_of(name)}")
        return DONE
    print(_described(name, network))
    if not yes and not _agreed():
        log("Nothing was downloaded.")
        return DONE
    folder = fetch(name)
    log(f"{name} is in {folder}; use it with --network {name}.")
    return DONE


@app.command(name="list")
def list_networks() -> int:
    """List the networks that can be got, and which of them are here."""
    for name, network in PUBLISHED.items():
        here = f"here, in {folder_of(name)}" if is_whole(name) else "not here"
        print(f"{_described(name, network)}\n  {here}")
    return DONE


def _described(name: str, network: PublishedNetwork) -> str:
    """Return what is to be known of a network before it is downloaded."""
    lines = [
        f"{name}: {network.title}, {network.size / 1e6:.1f} MB",
        f"  published at {network.source}",
        f"  license: {network.license}",
        *(f"  {file.url}" for file in network.files),
    ]
    return "\n".join(lines)


def _agreed() -> bool:
    """Ask whether to download; raise a ConfigError where nobody can answer."""
    if not sys.stdin.isatty():
        raise ConfigError("Nobody can be asked here whether to download it; add --yes.")
    print("Download it? [y/N] ", end="", flush=True)
    return sys.stdin.readline().strip().lower() in ("y", "yes")
