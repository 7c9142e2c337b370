"""`motes serve`: trackers for annotation tools."""

from __future__ import annotations

from pathlib import Path

from cyclopts import App

from motes import ConfigError, SourceError
from motes.cli import DONE, log
from motes.core import address_of

app = App(name="serve", help_format="plaintext", help="Track for annotation tools.")


@app.command(name="label-studio")
def label_studio(
    files: Path,
    /,
    *,
    host: str = "127.0.0.1",
    port: int = 9090,
    preset: str = "default",
) -> int:
    """Answer Label Studio as its ML backend, until Ctrl-C.

    Add http://ADDRESS:PORT to a project of video object tracking as a model, and switch on
    interactive preannotations. A rectangle that is drawn is then tracked to the end of the video.

    Parameters
    ----------
    files
        The folder of the videos, which Label Studio reads too. No other file is opened.
    host
        Address to listen at. Other computers cannot reach the default.
    port
        Port to listen at.
    preset
        Preset of the tracker; motes config lists all.
    """
    from motes import preset as preset_of
    from motes_fleet.services.label_studio import Backend

    preset_of(preset)
    if not files.is_dir():
        raise SourceError(f"There is no folder {files}; give that of the videos.")
    if not 0 < port < 65536:
        raise ConfigError(f"--port is {port}; give 1 to 65535.")
    with Backend(host, port, files, preset) as answering:
        address = address_of(host, port).rstrip("/")
        log(f"Label Studio finds the tracker at {address}; Ctrl-C ends it.")
        answering.serve_forever()
    return DONE
