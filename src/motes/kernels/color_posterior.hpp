// How probable it is that a sample is of the target, by its color of 32x32x32.
#pragma once

#include <algorithm>

#include "arrays.hpp"

namespace motes::color_posterior {

// A box in samples.
struct Box {
    double left, top, right, bottom;

    bool has(Index i, Index j) const {
        return top <= double(i) && double(i) < bottom && left <= double(j) && double(j) < right;
    }
};

// Returns how many samples of a window lie in a box.
inline Index inside_of(Box box, Index height, Index width) {
    Index across = 0, down = 0;
    for (Index j = 0; j < width; ++j) across += box.left <= double(j) && double(j) < box.right;
    for (Index i = 0; i < height; ++i) down += box.top <= double(i) && double(i) < box.bottom;
    return across * down;
}

// Returns the number of the color of a sample.
inline Index color32(Samples samples, Index i, Index j) {
    const auto level = [&](Index c) { return Index(limited(samples[c][i][j], 255.0f)) >> 3; };
    return (level(0) << 10) + (level(1) << 5) + level(2);
}

inline void fit_colors(Samples samples, Index inside, Index outside) {
    constexpr Index colors = 32 * 32 * 32;
    fit(samples.planes == 3 && inside == colors && outside == colors,
        "samples (3, H, W), and two rows of 32768 colors");
}

// Adds `share` of 32x32x32 colors: of samples in the box `inner`, and of those not in `outer`.
inline void add_colors(Samples samples, Box inner, Box outer, double share, Row<float> inside,
                       Row<float> outside) {
    const Index height = samples.rows, width = samples.columns;
    fit_colors(samples, inside.size, outside.size);
    const Index here = inside_of(inner, height, width);
    const Index there = height * width - inside_of(outer, height, width);
    const float one = float(share / double(std::max(here, Index(1))));
    const float other = float(share / double(std::max(there, Index(1))));
    for (Index i = 0; i < height; ++i)
        for (Index j = 0; j < width; ++j) {
            if (inner.has(i, j))
                inside[color32(samples, i, j)] += one;
            else if (!outer.has(i, j))
                outside[color32(samples, i, j)] += other;
        }
}

// Writes the sums (H + 1, W + 1), above and left of each corner, of inside / (inside + outside).
//
// A color that was never seen counts 1/2.
inline void color_integral(Samples samples, Row<const float> inside, Row<const float> outside,
                           Plane<double> out) {
    fit_colors(samples, inside.size, outside.size);
    fit(out.rows == samples.rows + 1 && out.columns == samples.columns + 1, "sums (H + 1, W + 1)");
    std::fill_n(out[0], out.columns, 0.0);
    for (Index i = 0; i < samples.rows; ++i) {
        double total = 0.0;
        out[i + 1][0] = 0.0;
        for (Index j = 0; j < samples.columns; ++j) {
            const Index color = color32(samples, i, j);
            total +=
                (double(inside[color]) + 1e-6) / (double(inside[color] + outside[color]) + 2e-6);
            out[i + 1][j + 1] = out[i][j + 1] + total;
        }
    }
}

}  // namespace motes::color_posterior
