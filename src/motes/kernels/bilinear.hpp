// Planes of values read between their points, and means over boxes from their sums.
#pragma once

#include <algorithm>

#include "arrays.hpp"

namespace motes::bilinear {

// Returns a plane's bilinear value at row y and column x, both inside it.
template <typename T>
double between(Plane<const T> plane, double y, double x) {
    const Index i = std::min(Index(y), plane.rows - 2), j = std::min(Index(x), plane.columns - 2);
    const double down = y - double(i), across = x - double(j);
    const T *upper = plane[i] + j, *lower = plane[i + 1] + j;
    const double high = (1 - across) * double(upper[0]) + across * double(upper[1]);
    const double low = (1 - across) * double(lower[0]) + across * double(lower[1]);
    return (1 - down) * high + down * low;
}

// Returns a plane's bilinear value off its middle; 0 outside of it. `step` is from one value to the
// next.
inline double value_at(Plane<const float> plane, double step, double x, double y) {
    x = double(plane.columns / 2) + x / step, y = double(plane.rows / 2) + y / step;
    const bool inside =
        0.0 <= x && x <= double(plane.columns - 1) && 0.0 <= y && y <= double(plane.rows - 1);
    return inside ? between(plane, y, x) : 0.0;
}

// Writes a plane's values at points (N, 2); see `value_at`.
inline void look_up(Plane<const float> plane, Table<const double> points, double step,
                    Row<double> out) {
    fit(plane.rows > 1 && plane.columns > 1 && points.columns >= 2 && out.size == points.rows,
        "a plane (2 or more, 2 or more), and points (N, 2)");
    for (Index n = 0; n < points.rows; ++n)
        out[n] = value_at(plane, step, points[n][0], points[n][1]);
}

// Returns the mean over a box, its center off the middle and its half sides, from sums.
//
// What reaches outside is left out; the box has at least one sample. `integral` has the sums above
// and left of each corner, so that four of them give the sum over a box.
inline double box_mean(Plane<const double> integral, double x, double y, Pair half) {
    const auto rows = double(integral.rows - 1), columns = double(integral.columns - 1);
    x += columns / 2, y += rows / 2;
    const double left = limited(x - half.x, columns - 1.0), top = limited(y - half.y, rows - 1.0);
    const double right = std::min(std::max(left + 1.0, x + half.x), columns);
    const double bottom = std::min(std::max(top + 1.0, y + half.y), rows);
    double total = between(integral, bottom, right) - between(integral, bottom, left);
    total += between(integral, top, left) - between(integral, top, right);
    return total / ((right - left) * (bottom - top));
}

// Writes the mean over boxes (N, 4), x and y off the middle and half sides, from sums.
inline void box_means(Plane<const double> integral, Table<const double> boxes, Row<double> out) {
    fit(integral.rows > 1 && integral.columns > 1 && boxes.columns >= 4 && out.size == boxes.rows,
        "sums (2 or more, 2 or more), and boxes (N, 4)");
    for (Index n = 0; n < boxes.rows; ++n) {
        const double* box = boxes[n];
        out[n] = box_mean(integral, box[0], box[1], {box[2], box[3]});
    }
}

}  // namespace motes::bilinear
