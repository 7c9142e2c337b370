"""`motes studio`: see, correct and trust tracks in a browser."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import App, Parameter

from motes.cli.exit_codes import DONE
from motes.cli.messages import log
from motes.cli.options import FLAG
from motes.core.errors import ConfigError, MissingDependencyError, SourceError

app = App(name="studio", help_format="plaintext")


@app.default
def studio(
    folder: Path | None = None,
    /,
    *,
    host: Annotated[
        str,
        Parameter(help="Address to listen at. Any but 127.0.0.1 asks for a token."),
    ] = "127.0.0.1",
    port: Annotated[int, Parameter(help="Port to listen at; 0 for any free one.")] = 8765,
    data: Annotated[
        Path | None,
        Parameter(help="Folder of sessions and uploads. [default: the user's folder for data]"),
    ] = None,
    browser: Annotated[
        bool, FLAG, Parameter(name="--headless", help="Do not open a browser.")
    ] = False,
) -> int:
    """Open a page in which tracks are made, seen and corrected, until Ctrl-C.

    Parameters
    ----------
    folder
        The folder of the films; other films are uploaded in the page.
    """
    try:
        from motes.studio.safety import Limits
        from motes.studio.serve import serve
    except ModuleNotFoundError as error:
        if error.name is None or error.name.startswith("motes"):
            raise
        raise MissingDependencyError(
            f"The studio needs {error.name}; install it with: pip install 'motes[studio]'."
        ) from None
    if folder is not None and not folder.is_dir():
        raise SourceError(f"There is no folder {folder}; give that of the films.")
    if not 0 <= port < 65536:
        raise ConfigError(f"--port is {port}; give 0 to 65535.")
    serve(folder, host, port, data, log=log, browser=not browser, limits=Limits())
    return DONE
