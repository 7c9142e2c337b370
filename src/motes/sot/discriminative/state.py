"""The state of the default tracker."""

from __future__ import annotations

from motes.core.geometry import Ellipse
from motes.core.types import Floats
from motes.cues.correlation_filter import ScaleModel
from motes.sot.discriminative.belief import Belief
from motes.sot.discriminative.localization import TargetModels
from motes.sot.discriminative.network_track import NetworkTrack
from motes.sot.discriminative.prediction import Light, MotionHistory
from motes.sot.discriminative.redetection import RedetectionModel
from motes.sot.discriminative.rival import Rival
from motes.sot.discriminative.size import Trend, TurnEstimate
from motes.sot.discriminative.standing import Standing


class DiscriminativeState(TargetModels, frozen=True, eq=False):
    """The state after a frame: the models, and all else that the next step needs."""

    ellipse: Ellipse
    """The last estimate: the ellipse in the target's box, turned as the target since the start."""
    shape: Ellipse
    """The first region; a track reports it moved, scaled and turned."""
    appearance: RedetectionModel
    """The histograms of the target's first region, for the search."""
    scale: ScaleModel
    """The model of the size."""
    border: Floats
    """(2,) running means of the posterior just inside and just outside of the target's border."""
    search_particles: Floats
    """(N, 5) the particles of the search; none while the target is tracked."""
    scale_due: bool
    """Whether the next frame estimates the size; the other frames try turned windows. Every other
    frame is enough for each, and a size that is estimated less often jitters less."""
    factors: Floats
    """(N,) particles of the size from its last estimate, as factors of the size before."""
    size: Trend
    turn: TurnEstimate
    """The size and the turn that are reported."""
    standing: Standing
    """Whether something like the target is there: it decides what is learned and searched for."""
    reported: Standing
    """The status that is reported: whether it is there and is the target, too."""
    rival: Rival
    """Another place that may be the target's."""
    motion: MotionHistory
    """The last motion of the target and of the camera."""
    light: Light
    """The light of the scene."""
    belief: Belief
    """Whether what is followed is the target or a neighbor."""
    network: NetworkTrack | None = None
    """The target as a trained network follows it, if there is one."""
