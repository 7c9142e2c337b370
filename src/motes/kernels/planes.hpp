// A picture as three planes, one for each color, and with another exposure.
#pragma once

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>

#include "arrays.hpp"

namespace motes::planes {

using Bytes = Plane<const std::uint8_t>;

// Writes a picture's red, green and blue, each value looked up in the table of its color (3, 256).
//
// All three go through one loop: a shorter one may take twice as long by where it lies in the code.
inline void expose(Picture picture, Bytes tables, Volume<std::uint8_t> out) {
    fit(tables.rows == 3 && tables.columns == 256 && out.planes == 3 &&
            out.rows == picture.height && out.columns == picture.width,
        "three tables of 256 values, and three planes of the picture's size");
    const Index r = picture.red(), g = picture.green(), b = picture.blue();
    const std::uint8_t *reds = tables[0], *greens = tables[1], *blues = tables[2];
    for (Index y = 0; y < picture.height; ++y) {
        const std::uint8_t* from = picture.row(y);
        std::uint8_t* __restrict red = out[0][y];
        std::uint8_t* __restrict green = out[1][y];
        std::uint8_t* __restrict blue = out[2][y];
        for (Index x = 0; x < picture.width; ++x, from += picture.pixel)
            red[x] = reds[from[r]], green[x] = greens[from[g]], blue[x] = blues[from[b]];
    }
}

// Writes a picture whose light is scaled by a factor, a row of red, green and blue for each pixel;
// what is brighter than white becomes white.
inline void relight(Picture picture, double factor, Volume<std::uint8_t> out) {
    fit(out.planes == picture.height && out.rows == picture.width && out.columns == 3,
        "a picture of the same size");
    const auto scale = std::uint32_t(factor * 65536 + 0.5);  // 16 bits after the point
    const Index places[] = {picture.red(), picture.green(), picture.blue()};
    const Index width = 3 * picture.width;
    Scratch<std::uint8_t> ordered(width);
    for (Index y = 0; y < picture.height; ++y) {
        const std::uint8_t* from = picture.row(y);
        if (picture.pixel != 3 || picture.order != Order::RGB) {
            std::uint8_t* __restrict to = ordered;
            for (Index x = 0; x < picture.width; ++x, from += picture.pixel, to += 3)
                for (Index c = 0; c < 3; ++c) to[c] = from[places[c]];
            from = ordered;
        }
        std::uint8_t* __restrict lit = out[y].data;
        for (Index i = 0; i < width; ++i)
            lit[i] = std::uint8_t(std::min((from[i] * scale + 32768) >> 16, 255u));
    }
}

// Writes the mean green of each block of side x side pixels, from the left and the top on.
inline void green_means(Picture picture, Index side, Plane<float> out) {
    fit(side > 0 && out.rows <= picture.height / side && out.columns <= picture.width / side,
        "blocks that lie in the picture");
    Scratch<std::uint32_t> sums(out.columns);
    for (Index i = 0; i < out.rows; ++i) {
        std::fill_n(sums.begin(), out.columns, std::uint32_t(0));
        for (Index y = i * side; y < (i + 1) * side; ++y) {
            const std::uint8_t* from = picture.row(y) + picture.green();
            for (Index j = 0; j < out.columns; ++j)
                for (Index k = 0; k < side; ++k, from += picture.pixel) sums[j] += *from;
        }
        for (Index j = 0; j < out.columns; ++j) out[i][j] = float(sums[j]) / float(side * side);
    }
}

// Returns the mean difference of two pictures (h, w).
inline double mean_difference(Table<const float> one, Table<const float> other) {
    fit(one.rows == other.rows && one.columns == other.columns, "two pictures of one size");
    double total = 0.0;
    for (Index i = 0; i < one.rows; ++i) {
        float sums[8] = {};  // side by side
        for (Index j = 0; j < one.columns; ++j) sums[j % 8] += std::abs(one[i][j] - other[i][j]);
        total += std::accumulate(sums, sums + 8, 0.0);
    }
    return total / double(one.rows * one.columns);
}

// Moves the values near the median to the front. Returns how many these are, and how many of the
// others are below them: all and none where too few are compared, or the median is not among them.
//
// The limits are taken from every 16th value. All values are compared with them without branches,
// which a processor would often predict wrongly.
template <typename T>
std::pair<Index, Index> near_middle(T* values, Index count) {
    const Index size = count / 16;
    const auto reach = Index(1.5 * std::sqrt(double(size)));  // three deviations of their median
    if (size / 2 <= reach) return {count, 0};
    Scratch<T> few(size);
    for (Index i = 0; i < size; ++i) few[i] = values[16 * i];
    T *low = few + (size / 2 - reach), *high = few + (size / 2 + reach);
    std::nth_element(few.begin(), low, few + size);
    std::nth_element(low + 1, high, few + size);
    const T least = *low, most = *high;
    Index below = 0, above = 0;
    for (Index i = 0; i < count; ++i) {
        below += Index(values[i] < least);
        above += Index(values[i] > most);
    }
    if (below >= count / 2 || above >= (count + 1) / 2) return {count, 0};  // both middle ones stay
    Index kept = 0;
    for (Index i = 0; i < count; ++i) {
        const T value = values[i];
        values[kept] = value;  // the next one takes its place if it is not near
        kept += Index(least <= value) & Index(value <= most);
    }
    return {kept, below};
}

// Returns the median of at least one value, none of them NaN; it changes their order.
template <typename T>
double median(T* values, Index count) {
    const auto [kept, smaller] = near_middle(values, count);
    T* middle = values + count / 2 - smaller;
    std::nth_element(values, middle, values + kept);
    const T below = count % 2 ? *middle : *std::max_element(values, middle);
    return double(below + *middle) / 2;
}

// Writes the median of each row of a picture.
inline void medians(Table<const float> picture, Row<float> out) {
    fit(picture.rows == out.size && picture.columns > 0, "a place for the median of each row");
    Scratch<float> values(picture.columns);
    for (Index i = 0; i < picture.rows; ++i) {
        std::copy_n(picture[i], picture.columns, values.begin());
        out[i] = float(median(values.begin(), picture.columns));
    }
}

// Returns how many points lie between two levels in both of two pictures (h, w), and the median of
// the ratios of the first to the second there; 0 if there are none.
inline std::tuple<Index, double> median_ratio(Table<const float> one, Table<const float> other,
                                              double least, double most) {
    fit(one.rows == other.rows && one.columns == other.columns && least >= 0.0,
        "two pictures of one size, and positive levels");
    const auto low = float(least), high = float(most);
    Scratch<float> ratios(one.rows * one.columns + 1);
    Index count = 0;
    for (Index i = 0; i < one.rows; ++i)
        for (Index j = 0; j < one.columns; ++j) {
            const float a = one[i][j], b = other[i][j];
            ratios[count] = a / b;  // the next one takes its place if it does not count
            count += Index(low < a) & Index(a < high) & Index(low < b) & Index(b < high);
        }
    return {count, count ? median(ratios.begin(), count) : 0.0};
}

// Returns a place beyond the border, mirrored at the pixel on the border.
inline Index mirrored(Index i, Index size) {
    while (i < 0 || i >= size) i = size == 1 ? 0 : i < 0 ? -i : 2 * (size - 1) - i;
    return i;
}

// Writes the sums over the 3 x 3 pixels around each; beyond the border the picture is mirrored.
inline void window_sums(Volume<const std::uint8_t> picture, Volume<std::uint16_t> out) {
    const Index height = picture.rows, width = picture.columns;
    fit(out.planes == picture.planes && same_size(picture, out) && width > 0,
        "planes, and as many sums");
    Scratch<std::uint16_t> sums(width + 2);
    std::uint16_t* __restrict column = sums + 1;
    for (Index c = 0; c < picture.planes; ++c)
        for (Index y = 0; y < height; ++y) {
            const std::uint8_t *above = picture[c][mirrored(y - 1, height)], *here = picture[c][y],
                               *below = picture[c][mirrored(y + 1, height)];
            for (Index x = 0; x < width; ++x)
                column[x] = std::uint16_t(above[x] + here[x] + below[x]);
            column[-1] = column[mirrored(-1, width)];
            column[width] = column[mirrored(width, width)];
            std::uint16_t* __restrict row = out[c][y];
            for (Index x = 0; x < width; ++x)
                row[x] = std::uint16_t(column[x - 1] + column[x] + column[x + 1]);
        }
}

}  // namespace motes::planes
