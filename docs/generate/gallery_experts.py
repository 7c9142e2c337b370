"""Make the picture of docs/default-tracker.md: the beliefs of look-alikes, and what experts see."""

from __future__ import annotations

import numpy as np
from PIL import Image, ImageDraw

from gallery_commands import side_by_side
from motes import Discriminative, Frame
from motes.core.geometry import Ellipse
from motes.core.types import Bytes, Floats
from motes.cues.correlation_filter import sample_response
from motes.cues.search_window import CELL_SIZE
from motes.output.overlay import draw, font
from motes.sot.discriminative.belief import GAIN, distances, look_at
from motes.sot.discriminative.expert import probability
from motes.sot.discriminative.state import DiscriminativeState
from motes.synthetic import Pitch

MOMENT = 48
"""The frame that is shown: two of the team are beside the player."""
PART = 200, 150
"""Width and height of the part of the film that is shown."""
ZOOM = 2
GLOW = 255, 120, 0
"""The color of a response."""
WITHIN, OUTSIDE = 0.6, 0.3
"""Brightness of the picture in a window, and of what the window does not hold."""


def responses(
    config: Discriminative, state: DiscriminativeState, frame: Frame, points: Floats
) -> list[Floats]:
    """Return the responses at points (N, 2) of the near window and of the confined filter, (N,).

    Where their windows do not reach, they are not a number.
    """
    place = state.ellipse
    samples = state.correlation.grid
    offsets = samples.offsets(place, points)
    spectra = config.correlation.spectra(samples, samples.sample_window(frame, place))
    plane, _ = config.correlation.responses(state.correlation, spectra)
    reach = np.array([samples.columns, samples.rows]) * CELL_SIZE / 2
    near = np.where((abs(offsets) < reach).all(axis=1), sample_response(plane, offsets), np.nan)
    view = config.confined.look(state.experts["confined"], frame, place)
    padded = np.pad(view.plane, 1, constant_values=np.nan)
    cells = np.rint((points - place[:2]) / view.pixels).astype(int) + len(view.plane) // 2 + 1
    column, row = np.clip(cells, 0, len(padded) - 1).T
    return [near, padded[row, column].astype(float)]


def glowing(pixels: Bytes, response: Floats) -> Bytes:
    """Return a gray picture that glows where there is a response (height, width)."""
    gray = pixels.mean(axis=2, keepdims=True).repeat(3, axis=2)
    share = np.clip(np.nan_to_num(response) / np.nanmax(response), 0, 1)[..., None]
    lit = gray * np.where(np.isnan(response), OUTSIDE, WITHIN)[..., None]
    out: Bytes = ((1 - share) * lit + share * np.array(GLOW)).astype(np.uint8)
    return out


def belief_of(state: DiscriminativeState, frame: Frame, place: Ellipse) -> float:
    """Return the belief in the target if a frame alone told it, and it were at a place."""
    known, look = state.belief, look_at(frame, place)
    own = distances(np.vstack([known.first, known.known]), look).min()
    return probability(GAIN * float(distances(known.neighbors, look).min() - own))


def part_of(pixels: Bytes, words: str, place: Ellipse) -> Bytes:
    """Return the part of a picture around a place, enlarged, with words on it."""
    width, height = PART
    left = int(np.clip(place.x - width / 2, 0, pixels.shape[1] - width))
    top = int(np.clip(place.y - height / 2, 0, pixels.shape[0] - height))
    part = Image.fromarray(pixels[top : top + height, left : left + width])
    part = part.resize((ZOOM * width, ZOOM * height))
    pen = ImageDraw.Draw(part)
    pen.text((8, 6), words, "white", font(16), stroke_width=2, stroke_fill="black")
    return np.array(part)


def picture() -> Bytes:
    """Return a frame with the beliefs of all who are there, and what both filters respond to."""
    config, rng = Discriminative(), np.random.default_rng(0)
    for frame, truths in Pitch():
        if not frame.index:
            state, _ = config.init(rng, frame, truths[0].ellipse)
            continue
        before = state
        state, info = config.step(rng, state, frame)
        if frame.index == MOMENT:
            break
    height, width = frame.pixels.shape[:2]
    points = np.stack(np.meshgrid(np.arange(width), np.arange(height)), axis=-1).reshape(-1, 2)
    near, wide = responses(config, before, frame, points.astype(float))
    shown = Image.fromarray(draw(frame.pixels, info.track, label=""))
    pen = ImageDraw.Draw(shown)
    for x, y, a, b, _ in (truth.ellipse for truth in truths[1:]):
        pen.rectangle((x - a, y - b, x + a, y + b), outline=GLOW)
    for place in (truth.ellipse for truth in truths):
        above, words = (place.x, place.y - place.b), f"{belief_of(state, frame, place):.2f}"
        pen.text(above, words, "white", font(9), "mb", stroke_width=1, stroke_fill="black")
    parts = (
        (np.array(shown), "beliefs"),
        (glowing(frame.pixels, near.reshape(height, width)), "near window"),
        (glowing(frame.pixels, wide.reshape(height, width)), "confined filter"),
    )
    return side_by_side(
        (part_of(pixels, words, state.ellipse) for pixels, words in parts), ZOOM * PART[1]
    )
