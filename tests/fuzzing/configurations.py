"""Configurations in TOML: of trackers, as `motes-lab evaluate` reads them, and of `motes watch`."""

from functools import cache

from motes.core.config import from_dict, from_toml, merge
from motes.mot.scene_config import WatchConfig
from motes.sot import presets
from motes_lab.adapters.registry import tracker_spec

from .outcomes import DefectError, outcome, put


def trackers() -> list[bytes]:
    names = ("default", "nummiaro:adaptive", "maggio", "ng_delp", "zhao_pei", "mean_shift")
    short = b'preset = "maggio"\nparticles = 80\n[color]\nbins = [8, 8, 8] # a comment\n'
    return [short, *(presets.preset(name).to_toml().encode() for name in names)]


def check_tracker(data: bytes) -> str:
    """Read the configuration of a tracker; what is read is written and read as the same."""

    def read() -> None:
        written = tracker_spec(str(put("tracker.toml", data))).configuration
        again = from_dict(from_toml(written, "it"), presets.TrackerConfig)
        if again.to_toml() != written:
            raise DefectError(f"A configuration is read as another one: {written}")

    return outcome(read)


def scenes() -> list[bytes]:
    whole = _scene().to_toml().encode()
    short = b'confirm = 3\n[detector]\ntype = "like"\nbox = [10, 20, 30, 40]\n'
    return [whole, short, b'[detector]\ntype = "background"\nhistory = 40\n']


def check_scene(data: bytes) -> str:
    """Read the configuration of a scene; what is read is written and read as the same."""

    def read() -> None:
        values = from_toml(data.decode(errors="replace"), "this file")
        config = from_dict(merge(_scene().to_dict(), values), WatchConfig)
        if from_dict(from_toml(config.to_toml(), "it"), WatchConfig) != config:
            raise DefectError(f"A configuration is read as another one: {config}")

    return outcome(read)


@cache
def _scene() -> WatchConfig:
    return WatchConfig.of("nummiaro:adaptive")
