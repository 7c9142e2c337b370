"""The check that the parts of a particle filter name cues that it has."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from motes.core.errors import ConfigError
from motes.sot.filtering.fusion import Fixed, Fusion
from motes.sot.filtering.model_update import Adaptation, PerCue


def check_cue_names(
    cues: Collection[str],
    updated: Collection[str],
    fusion: Fusion,
    adaptation: Adaptation,
) -> None:
    """Raise a ConfigError if a part names a cue that is not in use.

    Parameters
    ----------
    cues
        The names of the cues in use.
    updated
        Those of the cues whose models the part `adaptation` updates.
    """
    named: dict[str, Mapping[str, object]] = {}
    if isinstance(fusion, Fixed):
        named["fusion.weights"] = fusion.weights
    if isinstance(adaptation, PerCue):
        named["adaptation.cues"] = adaptation.cues
    for key, values in named.items():
        for name in values:
            if name not in cues:
                raise ConfigError(f"{key} names {name!r}; the cues in use are {', '.join(cues)}.")
            if key == "adaptation.cues" and name not in updated:
                raise ConfigError(
                    f"{key} names {name!r}, whose model has a learning_rate of its own; leave "
                    "it out there."
                )
