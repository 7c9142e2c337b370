"""Who is a neighbor, and identities of groups that nothing joins."""

import heapq

from test_reidentification import RIG, SHIFT

from motes_fleet.cameras.camera_report import CameraReport
from motes_fleet.cameras.reidentification import CrossCameraAssociation
from motes_fleet.cameras.rig_config import Camera, Rig, neighbors_of
from simulated_cameras import Building, Simulation


def joined(*rigs: Rig, letters: str = "xy") -> Rig:
    """Return several rigs as one, whose cameras have a letter each in front."""
    cameras, passages = [], []
    for letter, rig in zip(letters, rigs, strict=False):
        for camera in rig.camera:
            cameras.append(Camera(letter + camera.name, "", place=camera.place))
        for passage in rig.passage:
            one, other = (letter + end for end in passage.between)
            passages.append(type(passage)((one, other), passage.seconds))
    return Rig(tuple(cameras), tuple(passages))


def test_passages_and_overlaps_make_neighbors() -> None:
    assert neighbors_of(Rig.parse(RIG)) == {"hall": ("office",), "office": ("hall",)}
    assert neighbors_of(Rig.parse(RIG.partition("[[passage]]")[0] + SHIFT)) == {
        "hall": ("office",),
        "office": ("hall",),
    }
    apart = Rig.parse(RIG.partition("[[passage]]")[0])
    assert neighbors_of(apart) == {"hall": (), "office": ()}


def test_groups_give_the_identities_of_the_whole() -> None:
    """Each on its own, up to their numbers."""
    building = Building(2, 3)
    simulations = [Simulation(building, 15, 2, seed=seed) for seed in (0, 1)]
    rig = joined(building.rig(), building.rig())
    whole = CrossCameraAssociation(rig)
    groups = {
        letter: CrossCameraAssociation(joined(building.rig(), letters=letter)) for letter in "xy"
    }
    there, back = dict[int, tuple[str, int]](), dict[tuple[str, int], int]()
    reports = heapq.merge(
        *(
            (_renamed(report, letter) for report in simulation.reports())
            for letter, simulation in zip("xy", simulations, strict=True)
        ),
        key=lambda report: report.time,
    )
    for report in reports:
        letter = report.camera[0]
        expected, found = whole.update(report), groups[letter].update(report)
        assert expected.keys() == found.keys()
        for own, identity in expected.items():
            number = letter, found[own]
            assert there.setdefault(identity, number) == number
            assert back.setdefault(number, identity) == identity
    assert len(there) > 10
    assert whole.handed == sum(group.handed for group in groups.values()) > 10


def _renamed(report: CameraReport, letter: str) -> CameraReport:
    return CameraReport(
        letter + report.camera, report.frame, report.time, report.sightings, report.size
    )
