"""Compare histograms over a part of a region's pixels with the one over all of them.

    python benchmarks/checkerboard.py [IMAGE --region x,y,width,height]

Table 1 of Ng and Delp, with lattices in addition: coefficient, distance, likelihood with sigma 0.15
and time, for the color histogram of preset ng_delp. Without an image, the target of a rendered one
is read. Lattices of fewer points than a small region has pixels may read some of them twice.
"""

from __future__ import annotations

import argparse
import time

import numpy as np

from motes import Frame, synthetic
from motes.cues.color import Color
from motes.geometry import Ellipse
from motes.likelihood import Gaussian
from motes.sampling import Checkerboard, EveryPixel, Lattice, Sampling
from motes.video import open_source

SAMPLINGS: dict[str, Sampling] = {
    "all pixels": EveryPixel(),
    "half": Checkerboard(share="half"),
    "quarter": Checkerboard(share="quarter"),
    **{f"lattice of {points}": Lattice(points=points) for points in (64, 128, 256, 512)},
}
PAPER = {
    "all pixels": "1, 0, 1, 100%",
    "half": "0.9998, 0.0157, 0.9946, 38%",
    "quarter": "0.9993, 0.0258, 0.9853, 19%",
}


def picture(image: str | None, region: str | None) -> tuple[Frame, Ellipse]:
    """Return an image and the region of interest in it."""
    if image is None or region is None:
        frame, (target,) = synthetic.still((640, 480), target=(60, 100), frames=1)[0]
        return frame, target.ellipse
    with open_source(image) as source:
        frame = next(iter(source))
    return frame, Ellipse.from_box([float(number) for number in region.split(",")])


def seconds(cues: list[Color], frame: Frame, ellipse: Ellipse) -> list[float]:
    """Return the median time that each cue's histogram of the region takes, in turn with others'.

    The regions lie a little beside each other, or the processor would learn their pixels by heart.
    """
    regions = np.tile(np.array(ellipse), (100, 1))
    regions[:, :2] += np.random.default_rng(0).normal(0, 2, (100, 2))
    taken = np.empty((40, len(cues)))
    for row in taken:
        for number, cue in enumerate(cues):
            start = time.thread_time()
            cue.histograms(frame, regions)
            row[number] = time.thread_time() - start
    medians: list[float] = (np.median(taken, axis=0) / len(regions)).tolist()
    return medians


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("image", nargs="?")
    parser.add_argument("--region", help="x,y,width,height")
    options = parser.parse_args()
    if (options.image is None) != (options.region is None):
        parser.error("give an image and its --region, or neither")
    frame, ellipse = picture(options.image, options.region)
    print(f"An ellipse of {2 * ellipse.a:.0f}x{2 * ellipse.b:.0f} pixels.\n")
    print("| pixels read | rho | distance | likelihood | time | the paper's |")
    print("|---|---|---|---|---|---|")
    cues = [
        Color(space="hsv", bins=(8, 8, 4), kernel="epanechnikov", sampling=sampling)
        for sampling in SAMPLINGS.values()
    ]
    histograms = [cue.histograms(frame, np.array([ellipse]))[0] for cue in cues]
    times = seconds(cues, frame, ellipse)
    for name, histogram, taken in zip(SAMPLINGS, histograms, times, strict=True):
        rho = min(1.0, float(np.sqrt(histogram) @ np.sqrt(histograms[0])))
        distance = np.sqrt(1 - rho)
        likelihood = np.exp(Gaussian(sigma=0.15).log(["color"], np.array([[distance]])))[0, 0]
        print(
            f"| {name} | {rho:.4f} | {distance:.4f} | {likelihood:.4f} "
            f"| {1e6 * taken:.1f} µs, {taken / times[0]:.0%} | {PAPER.get(name, '')} |"
        )


if __name__ == "__main__":
    main()
