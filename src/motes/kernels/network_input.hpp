// A square of a picture in the size of a network's input, as OpenCV makes it.
#pragma once

#include <algorithm>
#include <cmath>

#include "arrays.hpp"

namespace motes::network_input {

constexpr float ONE = 2048.0f;  // a share of 1

// The two pixels of a side of `side` pixels that count for each of `count` samples, and how much.
//
// Sample i lies at (i + 1/2) side / count - 1/2. Beyond the outermost pixels these count alone; if
// `kept`, with both shares, as OpenCV has it for rows: their rounding differs.
class Shares {
public:
    Shares(Index side, Index count, bool kept) : pixels(count, 2), shares(count, 2) {
        const double step = 1.0 / (double(count) / double(side));
        for (Index i = 0; i < count; ++i) {
            const auto place = float((double(i) + 0.5) * step - 0.5);
            const auto before = Index(std::floor(place));
            const bool beyond = before < 0 || before >= side - 1;
            const float share = beyond && !kept ? 0.0f : place - float(before);
            pixels[i][0] = std::min(std::max(before, Index(0)), side - 1);
            pixels[i][1] = std::min(std::max(before + 1, Index(0)), side - 1);
            shares[i][0] = std::int32_t(std::nearbyint((1.0f - share) * ONE));
            shares[i][1] = std::int32_t(std::nearbyint(share * ONE));
        }
    }

    ScratchPlane<Index> pixels;
    ScratchPlane<std::int32_t> shares;
};

// Writes a row of the square's pixels, mixed across, as whole numbers: red, green, blue (3 W).
//
// `places` (W, 2) has the bytes of a row's pixels, or -1 for one beside the picture.
inline void mix_across(Picture picture, const std::uint8_t* row, const std::uint8_t* fill,
                       const ScratchPlane<Index>& places, const Shares& columns, Index width,
                       std::int32_t* out) {
    std::int32_t *red = out, *green = out + width, *blue = out + 2 * width;
    for (Index j = 0; j < width; ++j) {
        const bool left = row != nullptr && places[j][0] >= 0;
        const bool right = row != nullptr && places[j][1] >= 0;
        const std::uint8_t* here = left ? row + places[j][0] : fill;
        const std::uint8_t* beside = right ? row + places[j][1] : fill;
        const std::int32_t share = columns.shares[j][0], other = columns.shares[j][1];
        const auto mixed = [&](Index c) { return share * here[c] + other * beside[c]; };
        red[j] = mixed(picture.red()), green[j] = mixed(picture.green());
        blue[j] = mixed(picture.blue());
    }
}

// Writes rows mixed down, 0 to 255: the share of each is taken in OpenCV's steps of rounding.
inline void mix_down(const std::int32_t* __restrict upper, const std::int32_t* __restrict lower,
                     std::int32_t share, std::int32_t other, Index width, float* __restrict out) {
    for (Index j = 0; j < width; ++j) {
        const std::int32_t sum =
            (((upper[j] >> 4) * share) >> 16) + (((lower[j] >> 4) * other) >> 16);
        out[j] = float((sum + 2) >> 2);
    }
}

// Writes a square of a picture (3, H, W): red, green and blue, whole numbers 0 to 255.
//
// Its first pixel is `left`, `top`, its side `side` pixels; beside the picture it has the color
// `fill` (3). The values are those of OpenCV's `resize`, INTER_LINEAR, to the last bit.
inline void read_square(Picture picture, Index left, Index top, Index side, Floats fill,
                        Volume<float> out) {
    const Index height = out.rows, width = out.columns;
    const Shares columns(side, width, false), rows(side, height, true);
    ScratchPlane<Index> places(width, 2);
    for (Index j = 0; j < width; ++j) {
        for (Index k = 0; k < 2; ++k) {
            const Index x = left + columns.pixels[j][k];
            places[j][k] = x >= 0 && x < picture.width ? x * picture.pixel : -1;
        }
    }
    std::uint8_t color[3];
    color[picture.red()] = std::uint8_t(std::nearbyint(fill[0]));
    if (picture.order != Order::GRAY) {
        color[1] = std::uint8_t(std::nearbyint(fill[1]));
        color[picture.blue()] = std::uint8_t(std::nearbyint(fill[2]));
    }
    ScratchPlane<std::int32_t> lines(2, 3 * width);
    Index held[2] = {-1, -1};
    for (Index i = 0; i < height; ++i) {
        std::int32_t* mixed[2];
        for (Index k = 0; k < 2; ++k) {
            const Index wanted = rows.pixels[i][k], slot = wanted % 2;
            if (held[slot] != wanted) {
                const Index y = top + wanted;
                const bool inside = y >= 0 && y < picture.height;
                mix_across(picture, inside ? picture.row(y) : nullptr, color, places, columns,
                           width, lines[slot]);
                held[slot] = wanted;
            }
            mixed[k] = lines[slot];
        }
        for (Index c = 0; c < 3; ++c)
            mix_down(mixed[0] + c * width, mixed[1] + c * width, rows.shares[i][0],
                     rows.shares[i][1], width, out[c][i]);
    }
}

// Writes the mean of a picture's red, green and blue (3).
inline void mean_color(Picture picture, Row<double> out) {
    std::uint64_t sums[3] = {};
    for (Index y = 0; y < picture.height; ++y) {
        std::uint32_t red = 0, green = 0, blue = 0;
        const std::uint8_t* pixel = picture.row(y);
        for (Index x = 0; x < picture.width; ++x, pixel += picture.pixel)
            red += pixel[picture.red()], green += pixel[picture.green()],
                blue += pixel[picture.blue()];
        sums[0] += red, sums[1] += green, sums[2] += blue;
    }
    for (Index c = 0; c < 3; ++c) out[c] = double(sums[c]) / double(picture.height * picture.width);
}

}  // namespace motes::network_input
