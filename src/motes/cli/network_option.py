"""The option --network: a trained network that joins a tracker."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from motes.cli.options import CONFIGURATION
from motes.core.errors import ConfigError

if TYPE_CHECKING:
    from motes.sot.presets import TrackerConfig

NetworkFiles = Annotated[
    str | None,
    Parameter(
        name="--network",
        group=CONFIGURATION,
        help="Trained network that joins the tracker: an ONNX file, or several of one network: "
        "backbone.onnx,head.onnx. docs/network.md says where to get one.",
    ),
]


def with_network(settings: Mapping[str, Any], preset: str, given: str | None) -> Mapping[str, Any]:
    """Return settings with --network as their key `network.files`.

    Raises
    ------
    ConfigError
        If the preset takes no network, or the settings have this key too.
    """
    if given is None:
        return settings
    from motes.sot import presets
    from motes.sot.network.network import files_of

    if "network" not in presets.preset(preset).__struct_fields__:
        raise ConfigError(
            f"Preset {preset} takes no network; omit --network or choose another preset."
        )
    others = settings.get("network", {})
    if not isinstance(others, dict) or "files" in others:
        raise ConfigError("--network and --network.files contradict each other; give one.")
    return {**settings, "network": {**others, "files": [*files_of(given)]}}


def network_settings(files: Sequence[str]) -> dict[str, Any]:
    """Return the settings that name the files of a network; none without files."""
    return {"network": {"files": [*files]}} if files else {}


def open_network(config: TrackerConfig) -> None:
    """Open the network of a configuration, if it has one, before anything is written.

    Raises
    ------
    MotesError
        If its files cannot be used.
    """
    network = getattr(config, "network", None)
    if network is not None:
        network.open()
