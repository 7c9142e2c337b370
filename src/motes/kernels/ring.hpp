// How alike a picture and a larger one are around a hole, wherever the smaller one may lie in it.
#pragma once

#include <array>
#include <cstring>

#include "fourier_lines.hpp"

namespace motes::ring {

// Variances with a smaller product are of flat pictures.
constexpr double FLAT = 1e-3;

// Places in a row whose sums are kept in registers, and their vectors.
constexpr Index PLACES = 32, VECTORS = PLACES / fourier::LANES;

// The first column and row of the hole, and those behind it.
struct Hole {
    Index left, top, right, bottom;
};

// Writes the integral images of a picture and of its squares.
inline void integrate(Table<const float> picture, Plane<double> sums, Plane<double> squares) {
    std::fill_n(sums[0], sums.columns, 0.0);
    std::fill_n(squares[0], squares.columns, 0.0);
    for (Index i = 0; i < picture.rows; ++i) {
        double sum = 0, square = 0;
        sums[i + 1][0] = squares[i + 1][0] = 0;
        for (Index j = 0; j < picture.columns; ++j) {
            const double value = picture[i][j];
            sum += value;
            square += value * value;
            sums[i + 1][j + 1] = sums[i][j + 1] + sum;
            squares[i + 1][j + 1] = squares[i][j + 1] + square;
        }
    }
}

// Writes the sums of products of a ring and a picture, at `PLACES` places in a row.
inline void products(const ScratchPlane<float>& picture, const ScratchPlane<float>& ring, Index y,
                     Index x, float* out) {
    std::array<fourier::Lanes, VECTORS> sums{};
    for (Index i = 0; i < ring.rows(); ++i) {
        const float* there = picture[y + i] + x;
        for (Index j = 0; j < ring.columns(); ++j) {
            for (Index k = 0; k < VECTORS; ++k) {
                fourier::Lanes values;
                std::memcpy(&values, there + j + k * fourier::LANES, sizeof(values));
                sums[k] = sums[k] + ring[i][j] * values;
            }
        }
    }
    std::memcpy(out, &sums, sizeof(sums));
}

// Writes for each place of `small` in `large` the correlation of the points around the hole
// (Pearson's, -1 to 1; 0 where one of them is flat).
inline void correlations(Table<const float> large, Plane<const float> small, Hole hole,
                         Plane<float> out) {
    const Index h = small.rows, w = small.columns;
    const auto [left, top, right, bottom] = hole;
    fit(h > 0 && w > 0 && out.rows > 0 && out.rows == large.rows - h + 1 &&
            out.columns == large.columns - w + 1 && 0 <= left && left <= right && right <= w &&
            0 <= top && top <= bottom && bottom <= h && (right - left) * (bottom - top) < h * w,
        "a picture with a hole, a larger one, and room for its places there");
    const double count = double(h * w - (right - left) * (bottom - top));
    double mean = 0, power = 0;
    ScratchPlane<float> ring(h, w);  // the points around the hole, less their mean
    const auto around_hole = [&](auto visit) {
        for (Index i = 0; i < h; ++i)
            for (Index j = 0; j < w; ++j)
                if (i < top || i >= bottom || j < left || j >= right) visit(i, j);
    };
    around_hole([&](Index i, Index j) { mean += small[i][j] / count; });
    std::fill_n(ring.begin(), h * w, 0.0f);
    around_hole([&](Index i, Index j) {
        ring[i][j] = float(small[i][j] - mean);
        power += double(ring[i][j]) * ring[i][j];
    });
    ScratchPlane<float> picture(large.rows, large.columns + PLACES);  // with room at the right
    std::fill_n(picture.begin(), picture.rows() * picture.columns(), 0.0f);
    for (Index y = 0; y < large.rows; ++y) std::copy_n(large[y], large.columns, picture[y]);
    std::array<float, PLACES> sum;
    for (Index y = 0; y < out.rows; ++y) {
        for (Index x = 0; x < out.columns; x += PLACES) {
            products(picture, ring, y, x, sum.data());
            std::copy_n(sum.begin(), std::min(PLACES, out.columns - x), out[y] + x);
        }
    }
    ScratchPlane<double> sums(large.rows + 1, large.columns + 1);
    ScratchPlane<double> squares(large.rows + 1, large.columns + 1);
    integrate(large, sums, squares);
    const auto around = [&](const ScratchPlane<double>& image, Index y, Index x) {
        const auto inside = [&](Index l, Index t, Index r, Index b) {
            return image[y + b][x + r] - image[y + t][x + r] - image[y + b][x + l] +
                   image[y + t][x + l];
        };
        return inside(0, 0, w, h) - inside(left, top, right, bottom);
    };
    for (Index y = 0; y < out.rows; ++y) {
        for (Index x = 0; x < out.columns; ++x) {
            const double sum = around(sums, y, x);
            const double spread = (around(squares, y, x) - sum * sum / count) * power;
            out[y][x] = spread > FLAT * count * count ? float(out[y][x] / std::sqrt(spread)) : 0.0f;
        }
    }
}

}  // namespace motes::ring
