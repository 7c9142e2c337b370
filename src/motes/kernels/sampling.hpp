// Which pixels of an ellipse are read, and how much each counts.
//
// What takes microseconds and is called by many is not inlined: that would only take compilers
// longer.
#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "arrays.hpp"

namespace motes::sampling {

enum Profile : int { EPANECHNIKOV, RADIAL, UNIFORM, GAUSSIAN };

// A part of an image, and how it lies in memory.
struct Window {
    Index left, top, width, height;
    Index pixel, line;  // steps from a pixel, and from a row, to the next
};

inline Window window_of(const Picture& picture) {
    return {0, 0, picture.width, picture.height, picture.pixel, picture.line};
}

// Returns the window of a plane of values that begins at `left`, `top`.
inline Window window_of(Index left, Index top, Index width, Index height) {
    return {left, top, width, height, 1, width};
}

// Which pixels are read where there is no lattice: those whose row and column add up to a multiple
// of `across`, and whose row is a multiple of `down`. 1, 1 is every pixel.
struct Grid {
    Index across, down;
};

// How ellipses are read: at the points of `lattice`, (2, n) in the unit disk, or, where it is
// empty, at those of `grid`; and by which `profile` a pixel's weight falls with its distance.
struct Reading {
    Plane<const float> lattice;
    Grid grid;
    int profile;
};

// An ellipse, the direction of its half-axis a, and half of the width and height of its box.
struct Region {
    double x, y, a, b, cos, sin, across, down;
};

// Half of the largest box of an ellipse that is read, in pixels: in what is larger, 32 bits are too
// few for a place.
constexpr double WIDEST = 1e9;

// Returns whether an ellipse can cover pixels: finite, of positive size, and not absurdly large.
inline bool regular(const Region& region) {
    return region.a > 0.0 && region.b > 0.0 && std::isfinite(region.x + region.y) &&
           region.across < WIDEST && region.down < WIDEST;
}

inline Region region_of(const double* ellipse) {
    const double a = ellipse[2], b = ellipse[3];
    const double cos = std::cos(ellipse[4]), sin = std::sin(ellipse[4]);
    return {ellipse[0],
            ellipse[1],
            a,
            b,
            cos,
            sin,
            std::sqrt(a * a * cos * cos + b * b * sin * sin),
            std::sqrt(a * a * sin * sin + b * b * cos * cos)};
}

// Returns for how many points of an ellipse room is needed.
inline Index capacity(Window window, Ellipses ellipses, const Reading& reading) {
    if (reading.lattice.columns > 0) return reading.lattice.columns;
    double most = 0.0;
    for (Index n = 0; n < ellipses.rows; ++n) {
        const double half = std::max(ellipses[n][2], ellipses[n][3]);
        if (!(half > 0.0)) continue;  // nothing is read of it
        const double side = 2 * half + 2;
        most = std::max(
            most, std::min(side, double(window.width)) * std::min(side, double(window.height)));
    }
    return Index(most) + 1;
}

// Replaces 1 - r² from 0 to 1 by exp(-r² / 2), as a series right to 1e-11: vector code.
inline void bell(double* weights, Index count) {
    for (Index i = 0; i < count; ++i) {
        const double t = 0.5 * (weights[i] - 1.0);
        const double tail =
            1.0 + t / 6 * (1.0 + t / 7 * (1.0 + t / 8 * (1.0 + t / 9 * (1.0 + t / 10))));
        weights[i] = 1.0 + t * (1.0 + t / 2 * (1.0 + t / 3 * (1.0 + t / 4 * (1.0 + t / 5 * tail))));
    }
}

// The weight of a pixel, 1 - r²: r² is uu u² + vv v² at u, v in the ellipse's own half-axes.
//
// It is over the bandwidth sqrt(a² + b²) (RADIAL; Nummiaro et al., equation 2), over the ellipse
// itself (EPANECHNIKOV; GAUSSIAN, of which `bell` makes the rest), or 0 everywhere (UNIFORM).
inline Pair squared_distance(const Region& region, int profile) {
    const double a = region.a, b = region.b;
    if (profile == UNIFORM) return {0.0, 0.0};
    if (profile == RADIAL) return {a * a / (a * a + b * b), b * b / (a * a + b * b)};
    return {1.0, 1.0};
}

// As `pixels_within`, at the points of a lattice.
[[gnu::noinline]] inline Index on_lattice(Window window, const Region& region,
                                          const Reading& reading, std::uint32_t* __restrict offsets,
                                          double* __restrict weights) {
    const auto [left, top, width, height, pixel_step, line_step] = window;
    const auto [x, y, a, b, cos, sin, across, down] = region;
    const float ax = float(a * cos), ay = float(a * sin);
    const float bx = float(-b * sin), by = float(b * cos);
    const auto [uu, vv] = squared_distance(region, reading.profile);
    const float du = float(uu), dv = float(vv);
    // Places are counted from the ellipse's own corner, whole numbers taken off: so they are
    // positive and small, and single precision is right to 1e-4 pixels in an ellipse of 1,000.
    const double corner_x = std::floor(x + 0.5 - across), corner_y = std::floor(y + 0.5 - down);
    const float x0 = float(x + 0.5 - corner_x), y0 = float(y + 0.5 - corner_y);
    const Index column = Index(corner_x) - left, row = Index(corner_y) - top;
    const auto corner = std::uint32_t(row * line_step + column * pixel_step);
    const auto pixel = std::uint32_t(pixel_step), line = std::uint32_t(line_step);
    const float* __restrict us = reading.lattice[0];
    const float* __restrict vs = reading.lattice[1];
    const Index points = reading.lattice.columns;
    for (Index i = 0; i < points; ++i) {  // without branches, so that it becomes vector code
        const float u = us[i], v = vs[i];
        const auto px = std::int32_t(x0 + u * ax + v * bx);
        const auto py = std::int32_t(y0 + u * ay + v * by);
        offsets[i] = corner + (std::uint32_t(py) * line + std::uint32_t(px) * pixel);
        weights[i] = 1.0f - (u * u * du + v * v * dv);
    }
    if (reading.profile == GAUSSIAN) bell(weights, points);
    if (x - across < left || y - down < top || x + across + 1 >= left + width ||
        y + down + 1 >= top + height) {
        for (Index i = 0; i < points; ++i) {
            const Index at_x = column + std::int32_t(x0 + us[i] * ax + vs[i] * bx);
            const Index at_y = row + std::int32_t(y0 + us[i] * ay + vs[i] * by);
            const bool inside = at_x >= 0 && at_y >= 0 && at_x < width && at_y < height;
            // Again: what was computed above has 32 bits, and may be another pixel of a large
            // picture.
            offsets[i] = inside ? std::uint32_t(at_y * line_step + at_x * pixel_step) : 0;
            weights[i] = inside ? weights[i] : 0.0;
        }
    }
    return points;
}

// As `pixels_within`, at the pixels of a grid.
[[gnu::noinline]] inline Index on_grid(Window window, const Region& region, const Reading& reading,
                                       std::uint32_t* offsets, double* weights) {
    const auto [left, top, width, height, pixel, line] = window;
    const auto [x, y, a, b, cos, sin, across, down] = region;
    const auto [uu, vv] = squared_distance(region, reading.profile);
    const Index first = std::max(left, Index(std::ceil(x - across)));
    const Index last = std::min(left + width - 1, Index(std::floor(x + across)));
    const Index above = std::max(top, Index(std::ceil(y - down)));
    const Index below = std::min(top + height - 1, Index(std::floor(y + down)));
    const auto to_multiple = [](Index n, Index of) { return (of - n % of) % of; };
    const auto [columns, rows] = reading.grid;
    Index count = 0;
    for (Index row = above + to_multiple(above, rows); row <= below; row += rows) {
        for (Index column = first + to_multiple(row + first, columns); column <= last;
             column += columns) {
            const double u = ((column - x) * cos + (row - y) * sin) / a;
            const double v = ((row - y) * cos - (column - x) * sin) / b;
            if (u * u + v * v < 1.0) {
                offsets[count] = std::uint32_t((row - top) * line + (column - left) * pixel);
                weights[count] = 1.0 - (u * u * uu + v * v * vv);
                ++count;
            }
        }
    }
    if (reading.profile == GAUSSIAN) bell(weights, count);
    return count;
}

// Writes the pixels of an ellipse that are read, and their weights; returns how many.
//
// A pixel is its place in the flat window of an image. Lattice points outside weigh nothing.
// Coordinates are the image's, whatever the window, down to rounding.
inline Index pixels_within(Window window, const double* ellipse, const Reading& reading,
                           std::uint32_t* offsets, double* weights) {
    const auto [left, top, width, height, pixel, line] = window;
    const Region region = region_of(ellipse);
    const auto [x, y, a, b, cos, sin, across, down] = region;
    if (!regular(region)) return 0;
    if (x + across < left - 1 || y + down < top - 1 || x - across > left + width ||
        y - down > top + height)
        return 0;
    const auto read = reading.lattice.columns > 0 ? on_lattice : on_grid;
    return read(window, region, reading, offsets, weights);
}

// Returns the color of a pixel whose bytes, in an order, are the lower ones of a number.
template <Order order>
std::uint32_t color_of(std::uint32_t bytes) {
    if constexpr (order == Order::GRAY) return (bytes & 0xFF) * 0x010101;
    if constexpr (order == Order::BGR)  // compilers know the four bytes in reverse
        return ((bytes & 0xFF) << 24 | (bytes & 0xFF00) << 8 | (bytes >> 8 & 0xFF00) |
                bytes >> 24) >>
               8;
    return bytes & 0xFFFFFF;
}

// As `colors_at`, of a picture with an order.
//
// Four bytes are read at once, which is quicker than three; the last pixel may have only three.
template <Order order>
[[gnu::noinline]] void colors_in(Picture picture, const std::uint32_t* __restrict offsets,
                                 Index count, std::uint32_t* __restrict colors) {
    const std::uint8_t* data = picture.data;
    if constexpr (order == Order::GRAY) {
        for (Index i = 0; i < count; ++i) colors[i] = color_of<order>(data[offsets[i]]);
        return;
    }
    const auto bytes = [](const std::uint8_t* at) {
        return std::uint32_t(at[0]) | std::uint32_t(at[1]) << 8 | std::uint32_t(at[2]) << 16;
    };
    const auto last =
        std::uint32_t((picture.height - 1) * picture.line + (picture.width - 1) * picture.pixel);
    const std::uint32_t corner = color_of<order>(bytes(data + last));
    if (last == 0) return std::fill_n(colors, count, corner), void();
    const auto color_at = [&](std::uint32_t offset) {
        const std::uint8_t* at = data + offset;
        return color_of<order>(bytes(at) | std::uint32_t(at[3]) << 24);
    };
    std::uint32_t highest = 0;
    for (Index i = 0; i < count; ++i) highest = std::max(highest, offsets[i]);
    if (highest < last) {  // nearly always
        for (Index i = 0; i < count; ++i) colors[i] = color_at(offsets[i]);
        return;
    }
    for (Index i = 0; i < count; ++i)
        colors[i] = offsets[i] >= last ? corner : color_at(std::min(offsets[i], last - 1));
}

// Writes the colors at places in a picture, each as r + 256 g + 65536 b.
inline void colors_at(const Picture& picture, const std::uint32_t* offsets, Index count,
                      std::uint32_t* colors) {
    constexpr decltype(&colors_in<Order::RGB>) by_order[] = {
        colors_in<Order::RGB>, colors_in<Order::BGR>, colors_in<Order::GRAY>};
    by_order[int(picture.order)](picture, offsets, count, colors);
}

// Returns the values of a plane at the points of an ellipse, without those outside.
//
// The plane begins at `left`, `top`, in the units of the ellipse.
inline std::vector<float> values_within(Plane<const float> plane, Index left, Index top,
                                        Floats ellipse, const Reading& reading) {
    const Window window = window_of(left, top, plane.columns, plane.rows);
    fit(ellipse.size >= 5, "an ellipse, x, y, a, b, theta");
    const Index room = capacity(window, {ellipse.data, 1, ellipse.size, ellipse.size}, reading);
    Scratch<std::uint32_t> offsets(room);
    Scratch<double> weights(room);
    const Index count = pixels_within(window, ellipse.data, reading, offsets, weights);
    std::vector<float> values;
    values.reserve(std::size_t(count));
    for (Index i = 0; i < count; ++i)
        if (weights[i] > 0.0) values.push_back(plane.data[offsets[i]]);
    return values;
}

// Returns the left, top, right and bottom end of what ellipses cover.
//
// Those that are not `regular` cover nothing; the left end of nothing is right of its right end.
inline std::array<double, 4> bounds(Ellipses ellipses) {
    constexpr double inf = std::numeric_limits<double>::infinity();
    double left = inf, top = inf, right = -inf, bottom = -inf;
    for (Index n = 0; n < ellipses.rows; ++n) {
        const Region region = region_of(ellipses[n]);
        if (!regular(region)) continue;
        const auto [x, y, a, b, cos, sin, across, down] = region;
        left = std::min(left, x - across), top = std::min(top, y - down);
        right = std::max(right, x + across), bottom = std::max(bottom, y + down);
    }
    return {left, top, right, bottom};
}

}  // namespace motes::sampling
