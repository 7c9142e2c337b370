"""All kinds of input."""

from . import (
    calls,
    configurations,
    detections,
    evaluations,
    films,
    formats,
    histograms,
    options,
    places,
    sequences,
    states,
    track_rows,
)
from .campaign import Kind

KINDS = (
    Kind("rows", track_rows.seeds, track_rows.check),
    Kind("trackers", configurations.trackers, configurations.check_tracker),
    Kind("scenes", configurations.scenes, configurations.check_scene),
    Kind("doors", places.doors, places.check_doors),
    Kind("zones", places.counted, places.check_counted),
    Kind("rigs", places.rigs, places.check_rig, block=20),
    Kind("histograms", histograms.seeds, histograms.check),
    Kind("detections", detections.seeds, detections.check_detector),
    Kind("boxes", detections.seeds, detections.check_rows),
    Kind("truths", sequences.truths, sequences.check_truth),
    Kind("lists", sequences.lists, sequences.check_list),
    Kind("labels", sequences.labels, sequences.check_label),
    Kind("seqinfo", sequences.information, sequences.check_information),
    Kind("masks", sequences.masks, sequences.check_mask),
    Kind("records", evaluations.records, evaluations.check_record),
    Kind("traces", evaluations.traces, evaluations.check_trace),
    Kind("tracks", evaluations.tracks, evaluations.check_tracks),
    Kind("track-rows", detections.seeds, evaluations.check_track_rows),
    *formats.KINDS,
    Kind("options", options.seeds, options.check, block=20, limit=30.0),  # whole commands
    Kind("states", states.seeds, states.check, block=20, limit=30.0, mutate=states.mutate),
    Kind("calls", calls.seeds, calls.check, mutate=calls.mutate),
    *films.KINDS,
)
"""In the order of a round."""
