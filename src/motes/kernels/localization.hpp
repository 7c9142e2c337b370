// The place of a target in a window: particles over a filter's responses and a color posterior.
#pragma once

#include <algorithm>

#include "bilinear.hpp"
#include "particles.hpp"

namespace motes::localization {

// What is known of the points of a window, with the names of `PointCues` in Python.
struct PointCues {
    Plane<const float> response;
    double step;
    Plane<const double> integral;
    Pair core;
    double share, sigma;
    Pair deviation;
};

// Writes the log-weights of points (N, 2) off the window's middle.
inline void weigh(const PointCues& cues, Table<const double> points, Row<double> logs) {
    fit(cues.response.rows > 1 && cues.response.columns > 1 && cues.integral.rows > 1 &&
            cues.integral.columns > 1 && points.columns >= 2 && logs.size == points.rows,
        "a plane and sums (2 or more, 2 or more), and points (N, 2)");
    for (Index n = 0; n < points.rows; ++n) {
        const double x = points[n][0], y = points[n][1];
        const double response = bilinear::value_at(cues.response, cues.step, x, y);
        const double color = bilinear::box_mean(cues.integral, x, y, cues.core);
        const double across = x / cues.deviation.x, down = y / cues.deviation.y;
        logs[n] = ((1 - cues.share) * response + cues.share * color) / cues.sigma;
        logs[n] -= (across * across + down * down) / 2;
    }
}

// Writes which of some particles are selected, at even distances of their summed weights.
inline void select(Floats weights, double offset, Row<Index> chosen) {
    Scratch<double> positions(chosen.size);
    for (Index i = 0; i < chosen.size; ++i)
        positions[i] = (double(i) + offset) / double(chosen.size);
    particles::ancestors(weights, positions, chosen);
}

// Returns in how many squares, of a side, the chosen points lie.
inline Index occupied(const double* points, Row<const Index> chosen, double side) {
    constexpr double far = 1 << 20;
    const auto number = [&](double offset) {
        return std::int64_t(limited(std::floor(offset / side) + far, 2 * far));
    };
    Scratch<std::int64_t> squares(chosen.size);
    for (Index i = 0; i < chosen.size; ++i) {
        const double* point = points + 2 * chosen[i];
        squares[i] = number(point[0]) << 22 | number(point[1]);
    }
    std::int64_t *begin = squares.begin(), *end = begin + chosen.size;
    std::sort(begin, end);
    return std::unique(begin, end) - begin;
}

// Returns particles (n, 2) off the window's middle, of three layers.
//
// Half of the first are spread over the window, as wide as `half`, the others around the largest
// response, as wide as `narrow`. Then they are weighed, selected and moved by less and less noise.
// From the number of squares of a `side` in which they lie follows how many are left: `counts`
// (N + 1,). The random numbers are `normal` (3, N, 2) ones, and `offsets` (4,) from 0 to 1.
inline ScratchPlane<double> draw(const PointCues& cues, Volume<const double> normal, Floats offsets,
                                 Pair half, double narrow, double side, Row<const Index> counts) {
    const Plane<const float> response = cues.response;
    const Index most = normal.rows;
    fit(normal.planes == 3 && most > 0 && normal.columns == 2 && offsets.size == 4 &&
            counts.size == most + 1 && response.rows > 0 && response.columns > 0,
        "normal numbers (3, N, 2), four offsets, and a number for 0 to N squares");
    const float* values = response.data;
    const Index top = std::max_element(values, values + response.rows * response.columns) - values;
    const double x = double(top % response.columns - response.columns / 2) * cues.step;
    const double y = double(top / response.columns - response.rows / 2) * cues.step;
    Scratch<double> points(2 * most), logs(most), weights(most);
    Scratch<Index> chosen(most);
    for (Index n = 0; n < most; ++n) {
        const double* random = normal[0][n];
        points[2 * n] = n % 2 ? random[0] * narrow + x : random[0] * half.x;
        points[2 * n + 1] = n % 2 ? random[1] * narrow + y : random[1] * half.y;
    }
    Index count = most;
    for (Index layer = 1; layer < 3; ++layer) {
        const double spread = narrow / double(2 * layer);
        weigh(cues, {points, count, 2, 2}, {logs, count});
        particles::normalize({logs, count}, {weights, count});
        select({weights, count}, offsets[2 * layer - 2], {chosen, count});
        const Index squares = occupied(points, {chosen, count}, side);
        const Index left = std::min(std::max(counts[squares], Index(1)), most);
        select({weights, count}, offsets[2 * layer - 1], {chosen, left});
        Scratch<double> moved(2 * most);
        for (Index i = 0; i < 2 * left; ++i)
            moved[i] = points[2 * chosen[i / 2] + i % 2] + normal[layer][i / 2][i % 2] * spread;
        points = std::move(moved);
        count = left;
    }
    ScratchPlane<double> out(count, 2);
    std::copy_n(points.begin(), 2 * count, out.begin());
    return out;
}

}  // namespace motes::localization
