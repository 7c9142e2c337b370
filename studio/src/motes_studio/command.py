"""`motes studio`: see, correct and trust tracks in a browser."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

from cyclopts import App, Parameter

from motes import ConfigError, MissingDependencyError, SourceError
from motes.cli import DONE, FileName, Whole, log

app = App(name="studio", help_format="plaintext")


@app.default
def studio(
    folder: Path | None = None,
    /,
    *,
    host: str = "127.0.0.1",
    port: Whole = 8765,
    data: Path | None = None,
    network: FileName | None = None,
    headless: Annotated[bool, Parameter(negative=(), show_default=False)] = False,
) -> int:
    """Open a page in which tracks are made, seen and corrected, until Ctrl-C.

    Parameters
    ----------
    folder
        The folder of the films; other films are uploaded in the page.
    host
        Address to listen at. Any but 127.0.0.1 asks for a token.
    port
        Port to listen at; 0 for any free one.
    data
        Folder of sessions and uploads. [default: the user's folder for data]
    network
        Trained network that configurations of the page may name, as in motes track: nanotrack, or
        backbone.onnx,head.onnx. Or a folder of networks.
    headless
        Do not open a browser.
    """
    try:
        from motes_studio.safety import Limits
        from motes_studio.serve import serve
    except ModuleNotFoundError as error:
        if error.name is None or error.name.startswith("motes"):
            raise
        raise MissingDependencyError(
            f"The studio needs {error.name}; install it with: pip install 'motes[studio]'."
        ) from None
    if folder is not None and not folder.is_dir():
        raise SourceError(f"{folder} is not a folder; give that of the films.")
    if not 0 <= port < 65536:
        raise ConfigError(f"--port is {port}; give 0 to 65535.")
    limits = Limits() if network is None else Limits(networks=networks_of(network))
    serve(folder, host, port, data, log=log, browser=not headless, limits=limits)
    return DONE


def networks_of(given: str) -> tuple[str, ...]:
    """Return the files that a page may name: those of one network, or all in a folder."""
    from motes.sot import Network

    if not os.path.isdir(given):
        network = Network.named(given)
        network.open()
        return network.files
    found = sorted(map(str, Path(given).glob("*.onnx")))
    if not found:
        raise SourceError(f"{given} has no files .onnx; give a folder of networks.")
    return tuple(found)
