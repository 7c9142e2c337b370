// What of a picture tells whether it goes on or is another one: its colors, and a small gray
// picture.
#pragma once

#include <algorithm>

#include "arrays.hpp"

namespace motes::cuts {

// Counts the colors of every step-th pixel in x and y, each channel in eight bins, and writes the
// sums of all channels over blocks of these pixels. Returns how far their channels are apart, in
// the mean.
inline double look(Picture picture, Index step, Index block, Row<double> colors,
                   Plane<double> sums) {
    fit(step > 0 && block > 0 && colors.size == 512 &&
            sums.rows <= ((picture.height - 1) / step + 1) / block &&
            sums.columns <= ((picture.width - 1) / step + 1) / block,
        "512 colors, and blocks that lie in the picture");
    std::fill(colors.begin(), colors.end(), 0.0);
    std::fill_n(sums.data, sums.rows * sums.columns, 0.0);
    Index apart = 0, count = 0;
    for (Index y = 0; y < picture.height; y += step)
        for (Index x = 0; x < picture.width; x += step, ++count) {
            const std::uint8_t* from = picture.row(y) + x * picture.pixel;
            const int r = from[picture.red()], g = from[picture.green()], b = from[picture.blue()];
            colors[r >> 5 << 6 | g >> 5 << 3 | b >> 5] += 1;
            apart += std::max({r, g, b}) - std::min({r, g, b});
            const Index i = y / step / block, j = x / step / block;
            if (i < sums.rows && j < sums.columns) sums[i][j] += r + g + b;
        }
    return double(apart) / double(count);
}

}  // namespace motes::cuts
