"""The camera's motion by motes and by OpenCV's videostab, on films whose motion is exactly known.

    apt-get install g++ libopencv-videostab-dev
    python benchmarks/videostab.py MOT

MOT is a folder of sequences from still cameras, as for `motes-lab evaluate`. They are seen by the
moving camera of `motes-lab experiment moving-camera`, as pictures in a temporary folder. OpenCV's
Python packages have no videostab, so a small program in C++ is compiled; CXXFLAGS and LDFLAGS may
say where OpenCV is. Its default follows as many corners as ours, and as many as it takes by itself.
"""

from __future__ import annotations

import os
import shlex
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from PIL import Image

from motes.core.frame import Frame
from motes.core.types import Floats
from motes.mot.detection.global_motion import CORNERS, GlobalMotion
from motes_lab.datasets.mot import load_mot_dataset
from motes_lab.papers.moving_camera import View, motion_errors, view_frames
from motes_lab.report import markdown
from motes_lab.report.tables import Cell, Row, Table, number

OWN = 1000
"""Number of corners of videostab's own detector (`GFTTDetector`)."""
PROGRAM = r"""
#include <cstdio>
#include <cstdlib>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videostab.hpp>
using namespace cv;
using namespace cv::videostab;
int main(int, char **words) {
  std::vector<String> files;
  glob(words[1], files);
  auto model = makePtr<MotionEstimatorRansacL2>(*words[2] == 'h' ? MM_HOMOGRAPHY : MM_SIMILARITY);
  KeypointBasedMotionEstimator estimator(model);
  estimator.setDetector(GFTTDetector::create(std::atoi(words[3])));
  Mat last;
  double seconds = 0;
  for (const auto &file : files) {
    const Mat picture = imread(file);
    if (!last.empty()) {
      const auto begun = getTickCount();
      bool clear = false;
      Mat motion = estimator.estimate(last, picture, &clear);
      seconds += (getTickCount() - begun) / getTickFrequency();
      motion.convertTo(motion, CV_64F);
      for (int i = 0; i < 9; i++) std::printf("%.17g ", motion.at<double>(i / 3, i % 3));
      std::printf("\n");
    }
    last = picture;
  }
  std::printf("%g\n", seconds);
}
"""


def compiled(folder: Path) -> Path:
    """Return the compiled program; end with a message if that fails."""
    source, program = folder / "videostab.cpp", folder / "videostab"
    source.write_text(PROGRAM)
    more = [shlex.split(os.environ.get(name, "")) for name in ("CXXFLAGS", "LDFLAGS")]
    libraries = [f"-lopencv_{name}" for name in ("videostab", "features2d", "imgcodecs", "core")]
    names = [str(source), "-o", str(program)]
    command = ["g++", "-O2", "-I/usr/include/opencv4", *more[0], *names]
    if subprocess.run([*command, *more[1], *libraries], check=False).returncode:
        sys.exit("videostab is missing; install g++ and libopencv-videostab-dev.")
    return program


def by_videostab(
    program: Path, pictures: Path, model: str, corners: int
) -> tuple[list[Floats], float]:
    """Return the motions between the pictures of a folder, and milliseconds for each."""
    command = [str(program), str(pictures / "*.png"), model, str(corners)]
    answer = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    *lines, seconds = answer.splitlines()
    motions = [np.array(line.split(), np.float64).reshape(3, 3) for line in lines]
    return motions, 1000 * float(seconds) / len(motions)


def by_motes(frames: Iterator[Frame], model: str) -> tuple[list[Floats], float]:
    """Return the motions between frames, and milliseconds for each."""
    estimator, found, seconds = GlobalMotion(model), list[Floats](), 0.0  # type: ignore[arg-type]
    for frame in frames:
        begun = time.perf_counter()
        motion = estimator.update(frame.pixels)
        seconds += time.perf_counter() - begun
        found.append(np.eye(3) if motion is None else motion)
    return found[1:], 1000 * seconds / (len(found) - 1)


def main() -> None:
    sequences, _ = load_mot_dataset(Path(sys.argv[1]))
    errors: dict[str, list[Floats]] = {}
    times: dict[str, list[float]] = {}

    def add(name: str, view: View, motions: list[Floats], milliseconds: float) -> None:
        errors.setdefault(name, []).append(motion_errors(view, motions))
        times.setdefault(name, []).append(milliseconds)

    with tempfile.TemporaryDirectory() as place:
        program = compiled(Path(place))
        for sequence in sequences:
            pictures = Path(place, sequence.name)
            pictures.mkdir()
            view, frames = view_frames(sequence, moves=True)
            for frame in frames:
                Image.fromarray(frame.pixels).save(pictures / f"{frame.index:06}.png")
            add("nothing", view, [np.eye(3)] * (sequence.frames - 1), 0.0)
            for model in ("similarity", "homography"):
                add(f"motes, {model}", view, *by_motes(view_frames(sequence, moves=True)[1], model))
                for corners in (CORNERS, OWN):
                    found = by_videostab(program, pictures, model, corners)
                    add(f"videostab, {model}, {corners} corners", view, *found)
    rows: list[Row] = []
    for name, each in errors.items():
        quantiles = np.quantile(np.concatenate(each), [0.5, 0.95, 1]).tolist()
        cells = (number(value, 2) for value in quantiles)
        rows.append((Cell(name), *cells, number(float(np.mean(times[name])), 1)))
    head = "motion", "median", "95 % below", "worst", "ms"
    print(markdown.table(Table("The camera's motion, in pixels off", head, rows)))


if __name__ == "__main__":
    main()
