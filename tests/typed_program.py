"""A program of a user, written as the pages show: `make lint` finds nothing wrong with its types.

It is not run.
"""

import cv2
import numpy as np

import motes

# The one-line swap: tracker = cv2.TrackerCSRT.create()
tracker = motes.OpenCVTracker.create()
capture = cv2.VideoCapture("film.mp4")
ok, image = capture.read()
tracker.init(image, cv2.selectROI("frame", image))
ok, box = tracker.update(image)
cv2.rectangle(image, box[:2], (box[0] + box[2], box[1] + box[3]), (0, 255, 0))

boxes = np.array([[300.0, 200.0, 40.0, 60.0]])
one = motes.Tracker()
one.init(image, boxes[0])
one.correct(boxes[0])
with motes.Trackers(bgr=True) as several:
    several.init(image, boxes)
    several.add(boxes[0])
    several.save("saved")
tracks = motes.correct("film.mp4", {0: boxes[0], 9: (1, 2, 30, 40), 12: None})


def rows(picture: motes.Frame) -> list[tuple[float, float, float, float, float]]:
    return [(10.0, 20.0, 30.0, 40.0, 0.9)]


def found(frame: motes.Frame) -> list[motes.Detection]:
    return [motes.Detection((10, 20, 30, 40), 0.9), motes.Detection(boxes[0])]


for detector in (rows, found):
    motes.Scene(detector).update(image)
motes.Scene(lambda frame: boxes)
one.detect(image, rows)
with motes.VideoWriter("drawn.mp4", fps=25) as video:
    video.write(motes.draw(image, one.update(image), trail=boxes[:, :2]))
    video.write(motes.draw_scene(image, [], {}))
