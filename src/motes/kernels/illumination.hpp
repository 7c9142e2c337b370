// Which pixels of a mask differ from the background by their light alone, or by a tremble.
//
// Pictures are sums over 3 x 3 pixels, `planes::window_sums`: nine times the means.
#pragma once

#include <cmath>
#include <cstring>

#include "planes.hpp"

namespace motes::illumination {

using Bytes = Plane<const std::uint8_t>;
using Sums = Volume<const std::uint16_t>;

// What another light may change; see `BackgroundConfig`.
struct Limits {
    double shadow, highlight, tint, texture;
};

constexpr Index EDGES = 5;  // edges are compared over a window of this width and height

inline bool any(const std::uint8_t* mask, Index size) {
    return std::memchr(mask, 1, std::size_t(size)) != nullptr;
}

// Writes how much brighter a row of a picture is than the background's, and whether light alone may
// have changed its colors: by this factor, but for a tint.
inline void colors(Sums seen, Sums usual, Index y, const Limits& limits, float* __restrict factor,
                   std::uint8_t* __restrict same) {
    const std::uint16_t *r = seen[0][y], *g = seen[1][y], *b = seen[2][y];
    const std::uint16_t *red = usual[0][y], *green = usual[1][y], *blue = usual[2][y];
    const auto shadow = float(limits.shadow), highlight = float(limits.highlight);
    const auto tint = float(9 * limits.tint);
    for (Index x = 0; x < seen.columns; ++x) {
        const float f = float(r[x] + g[x] + b[x] + 9) / float(red[x] + green[x] + blue[x] + 9);
        const float off = std::max(std::abs(float(r[x]) - f * float(red[x])),
                                   std::max(std::abs(float(g[x]) - f * float(green[x])),
                                            std::abs(float(b[x]) - f * float(blue[x]))));
        factor[x] = f;
        same[x] = std::uint8_t((f > shadow) & (f < highlight) & (off < tint));
    }
}

// Writes the differences between the gradients of a row's green, in x and y, and those of the
// background times the factor, 18 times as large; 0 outside of the mask.
inline void edges(Sums seen, Sums usual, Index y, const std::uint8_t* mask, const float* factor,
                  float* __restrict out) {
    const Index height = seen.rows, width = seen.columns;
    const Index above = y > 0 && y < height - 1 ? y - 1 : y, below = 2 * y - above;
    const std::uint16_t *here = seen[1][y], *up = seen[1][above], *down = seen[1][below];
    const std::uint16_t *own = usual[1][y], *over = usual[1][above], *under = usual[1][below];
    const auto steps = [&](Index x, Index left, Index right) {
        const float across = float(here[right] - here[left]), fall = float(down[x] - up[x]);
        const float usually = float(own[right] - own[left]), drop = float(under[x] - over[x]);
        return mask[x] ? std::abs(across - factor[x] * usually) + std::abs(fall - factor[x] * drop)
                       : 0.0f;
    };
    out[0] = steps(0, 0, 0);
    out[width - 1] = steps(width - 1, 0, 0);
    for (Index x = 1; x < width - 1; ++x) out[x] = steps(x, x - 1, x + 1);
}

// Writes the sums of five values in a row; beyond its ends, which have room, it is mirrored.
template <typename T>
void across(T* values, Index width, T* __restrict out) {
    for (Index k = 1; k <= EDGES / 2; ++k) {
        values[-k] = values[planes::mirrored(-k, width)];
        values[width - 1 + k] = values[planes::mirrored(width - 1 + k, width)];
    }
    for (Index x = 0; x < width; ++x)
        out[x] = T(values[x - 2] + values[x - 1] + values[x] + values[x + 1] + values[x + 2]);
}

// Writes a mask without the pixels that differ by their light alone.
//
// Light has scaled the colors, and the mean difference of the gradients is small over the pixels of
// the mask around. Rows come in turn, and what five of them have is kept in a ring.
inline void without_light(Bytes mask, Sums seen, Sums usual, Limits limits,
                          Plane<std::uint8_t> out) {
    const Index height = mask.rows, width = mask.columns, reach = EDGES / 2;
    fit(seen.planes == 3 && usual.planes == 3 && same_size(mask, seen, usual, out) && width > 0,
        "a mask and two pictures of its size");
    const auto texture = float(18 * limits.texture);
    Scratch<float> factor(width), line(width + 2 * reach);
    Scratch<std::uint8_t> inside(width + 2 * reach);
    ScratchPlane<float> steps(EDGES, width);
    ScratchPlane<std::uint8_t> counts(EDGES, width), same(EDGES, width);
    for (Index y = 0; y < height + reach; ++y) {
        if (y < height) {
            const Index slot = y % EDGES;
            if (any(mask[y], width)) {
                colors(seen, usual, y, limits, factor, same[slot]);
                edges(seen, usual, y, mask[y], factor, line + reach);
                across(line + reach, width, steps[slot]);
                std::copy_n(mask[y], width, inside + reach);
                across(inside + reach, width, counts[slot]);
            } else {
                std::fill_n(steps[slot], width, 0.0f);
                std::fill_n(counts[slot], width, std::uint8_t(0));
            }
        }
        const Index row = y - reach;
        if (row < 0) continue;
        std::copy_n(mask[row], width, out[row]);
        if (!any(mask[row], width)) continue;
        const float* s[EDGES];
        const std::uint8_t* n[EDGES];
        for (Index k = 0; k < EDGES; ++k) {
            const Index slot = planes::mirrored(row + k - reach, height) % EDGES;
            s[k] = steps[slot], n[k] = counts[slot];
        }
        const std::uint8_t* alike = same[row % EDGES];
        std::uint8_t* __restrict left = out[row];
        for (Index x = 0; x < width; ++x) {
            const float sum = s[0][x] + s[1][x] + s[2][x] + s[3][x] + s[4][x];
            const int count = n[0][x] + n[1][x] + n[2][x] + n[3][x] + n[4][x];
            left[x] &= std::uint8_t(!(alike[x] & (sum < texture * float(count))));
        }
    }
}

// Writes a mask without the pixels all of whose colors are between two of the background.
inline void without_tremble(Bytes mask, Volume<const std::uint8_t> picture,
                            Volume<const std::uint8_t> low, Volume<const std::uint8_t> high,
                            Plane<std::uint8_t> out) {
    const Index size = mask.rows * mask.columns;
    fit(picture.planes == 3 && low.planes == 3 && high.planes == 3 &&
            same_size(mask, picture, low, high, out),
        "a mask and three pictures of its size");
    std::uint8_t* __restrict left = out.data;
    std::fill_n(left, size, std::uint8_t(0));
    for (Index c = 0; c < 3; ++c) {
        const std::uint8_t *own = picture[c].data, *least = low[c].data, *most = high[c].data;
        for (Index i = 0; i < size; ++i)
            left[i] |= std::uint8_t(mask.data[i] & ((own[i] < least[i]) | (own[i] > most[i])));
    }
}

}  // namespace motes::illumination
