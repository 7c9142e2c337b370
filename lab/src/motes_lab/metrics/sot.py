"""Metrics for one object: pure functions on arrays with a row for each frame."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motes.core import Floats
from motes.cues import sunflower

THRESHOLDS = np.linspace(0, 1, 21)
"""Overlaps at which the success curve is computed."""

PIXELS = np.arange(51)
"""Distances at which the precision curve is computed, in pixels."""

BINS = 10
"""Number of equally wide bins of confidence."""

LOST_OD = 0.8
"""A track is lost if its overlap distance is greater (Maggio et al., section 5)."""


REAPPEARANCE = 30
"""A loss counts only if the target is later present for this many frames in a row."""

CHI_SQUARE_95 = 5.991
"""The 95 % quantile of the chi-square distribution with 2 degrees of freedom."""

_POINTS = 4096
_CHUNK = 32


def success_curve(overlaps: Floats) -> Floats:
    """Return the share of frames whose overlap (IoU) exceeds each of `THRESHOLDS`, (21,).

    Overlaps have shape (frames,). NaN without frames. Wu, Lim and Yang, Online object tracking: a
    benchmark, CVPR 2013.
    """
    return _shares(overlaps[:, None] > THRESHOLDS)


def success_auc(overlaps: Floats) -> float:
    """Return the area under the success curve, as the mean over its 21 thresholds from 0 to 1."""
    return float(success_curve(overlaps).mean())


def precision_curve(distances: Floats) -> Floats:
    """Return the share of frames whose distance between centers is at most each of `PIXELS`, (51,).

    Distances (frames,) are in pixels. NaN without frames. Wu, Lim and Yang, CVPR 2013; they rank
    trackers by the share at 20 pixels.
    """
    return _shares(distances[:, None] <= PIXELS)


def _shares(passed: NDArray[np.bool_]) -> Floats:
    shares: Floats = passed.mean(axis=0) if len(passed) else np.full(passed.shape[1], np.nan)
    return shares


def enclosing_boxes(ellipses: Floats) -> Floats:
    """Return the smallest boxes x, y, w, h (n, 4) around ellipses (n, 5), as `Ellipse.box`."""
    x, y, a, b, theta = ellipses.T
    cos, sin = np.cos(theta), np.sin(theta)
    half_width, half_height = np.hypot(a * cos, b * sin), np.hypot(a * sin, b * cos)
    return np.stack(
        [x - half_width + 0.5, y - half_height + 0.5, 2 * half_width, 2 * half_height], axis=1
    )


def overlap_distances(ellipses: Floats, truths: Floats) -> Floats:
    """Return the overlap distance OD of each ellipse from its truth, (n,).

        OD = 1 - 2 TP / (|A_c| + |A_gt|)

    TP is the common area of the two. Maggio, Smeraldi and Cavallaro, equation 11. TP is computed as
    the area of the truth times the share of 4096 points, spread evenly over it, that lie in the
    ellipse.

    Parameters
    ----------
    ellipses, truths
        (n, 5): x, y, a, b, theta. A row that is not an ellipse has the largest distance, OD 1;
        without a truth OD is NaN.
    """
    out = np.ones(len(truths))
    out[~_regions(truths)] = np.nan
    both = np.flatnonzero(_regions(ellipses) & _regions(truths))
    u, v = sunflower(_POINTS)
    monomials = np.stack([u * u, u * v, v * v, u, v, np.ones(_POINTS)])
    for rows in np.split(both, range(_CHUNK, len(both), _CHUNK)):
        radii = _squared_radius(ellipses[rows], truths[rows]) @ monomials
        areas, true_areas = (np.pi * each[rows, 2] * each[rows, 3] for each in (ellipses, truths))
        common = np.minimum((radii <= 1).mean(axis=1) * true_areas, areas)
        out[rows] = 1 - 2 * common / (areas + true_areas)
    return out


def _regions(ellipses: Floats) -> NDArray[np.bool_]:
    return np.asarray(np.isfinite(ellipses).all(axis=1) & (ellipses[:, 2:4] > 0).all(axis=1))


def _squared_radius(ellipses: Floats, truths: Floats) -> Floats:
    """Return the squared distances of a truth's points from the ellipse, in its half-axes.

    The result (n, 6) holds polynomials of u², uv, v², u, v and 1, where (u, v) is the position of a
    point of the truth in the unit disk. A point with a value of at most 1 lies in the ellipse.
    """
    x, y, a, b, theta = ellipses.T
    true_x, true_y, true_a, true_b, true_theta = truths.T
    cos, sin, dx, dy = np.cos(theta), np.sin(theta), true_x - x, true_y - y
    turn_cos, turn_sin = np.cos(true_theta - theta), np.sin(true_theta - theta)
    # A point is at (p0 + p1 u + p2 v, q0 + q1 u + q2 v) in the unit disk of the ellipse.
    p0, p1, p2 = (cos * dx + sin * dy) / a, true_a * turn_cos / a, -true_b * turn_sin / a
    q0, q1, q2 = (cos * dy - sin * dx) / b, true_a * turn_sin / b, true_b * turn_cos / b
    return np.stack(
        [
            *(p1 * p1 + q1 * q1, 2 * (p1 * p2 + q1 * q2), p2 * p2 + q2 * q2),
            *(2 * (p0 * p1 + q0 * q1), 2 * (p0 * p2 + q0 * q2), p0 * p0 + q0 * q0),
        ],
        axis=1,
    )


def first_lost(distances: Floats) -> int | None:
    """Return the first row whose overlap distance exceeds `LOST_OD`, or None."""
    lost = np.flatnonzero(distances > LOST_OD)
    return int(lost[0]) if lost.size else None


def recoveries(
    present: NDArray[np.bool_], missed: NDArray[np.bool_], correct: NDArray[np.bool_]
) -> tuple[int, int]:
    """Return the number of losses, and the number of losses after which the target was found again.

    A loss is a frame in which the target is missed after it was not missed in the last frame with
    the target. It counts if the target is present in `REAPPEARANCE` frames in a row that begin in
    this frame or later. The target is found again if some later frame is correct.

    Parameters
    ----------
    present, missed, correct
        (frames,): whether there is a target, whether the tracker misses it, and whether the overlap
        is large enough. Without a target, the latter two do not matter.
    """
    if len(present) < REAPPEARANCE:
        return 0, 0
    there = np.flatnonzero(present)
    losses = there[1:][missed[there[1:]] & ~missed[there[:-1]]]
    rows = np.convolve(present, np.ones(REAPPEARANCE, int), "valid") == REAPPEARANCE
    begins, finds = (np.flatnonzero(flags) for flags in (rows, present & correct))
    losses = losses[losses <= begins.max(initial=-1)]
    return len(losses), int(np.count_nonzero(losses < finds.max(initial=-1)))


def covered(offsets: Floats, covariances: Floats) -> NDArray[np.bool_]:
    """Return whether points lie in the 95 % ellipses of normal distributions, (n,).

    A point at offset d does if d' C^-1 d <= `CHI_SQUARE_95`. None does if C has no area, or is NaN.

    Parameters
    ----------
    offsets
        (n, 2), offsets of the points from the means.
    covariances
        (n, 3): xx, xy, yy.
    """
    (x, y), (xx, xy, yy) = offsets.T, covariances.T
    area = xx * yy - xy * xy
    inside = yy * x * x - 2 * xy * x * y + xx * y * y <= CHI_SQUARE_95 * area
    return np.asarray(inside & (area > 0))


def calibration_error(confidence: Floats, correct: NDArray[np.bool_], weights: Floats) -> float:
    """Return the expected calibration error (ECE) of confidences (frames,); NaN without frames.

    It is the mean, over `BINS` equally wide bins of confidence weighted by their share of the
    frames, of the difference between the mean confidence and the share of correct frames. Guo,
    Pleiss, Sun and Weinberger, On calibration of modern neural networks, ICML 2017. `weights`
    (frames,) make it possible that all sequences count equally, whatever their length.
    """
    if not confidence.size:
        return np.nan
    bins = np.clip((confidence * BINS).astype(int), 0, BINS - 1)
    gaps = np.bincount(bins, weights * (correct - confidence))
    return float(np.abs(gaps).sum() / weights.sum())


def time_quantiles(seconds: Floats) -> tuple[float, float]:
    """Return median and 95th percentile of running times (n,), in milliseconds; NaN if n is 0."""
    if not seconds.size:
        return np.nan, np.nan
    median, high = np.quantile(seconds, [0.5, 0.95]) * 1000
    return float(median), float(high)
