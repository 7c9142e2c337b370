// Edges by Sobel's operator, and histograms of their orientation.
#pragma once

#include "gradients.hpp"
#include "histograms.hpp"

namespace motes::sobel {

// Writes the bins of edges' orientations, `count` where one is no strong edge.
//
// Ng and Delp, equations 12 to 14. The `count` bins are of equal width over half a turn, the first
// one centered on -pi/2, a horizontal edge.
inline void edge_bins(const float* __restrict gx, const float* __restrict gy, Index size,
                      double threshold, std::int32_t count, std::uint8_t* __restrict bins) {
    const double square = threshold * threshold;
    const float least = float(square * square);
    for (Index i = 0; i < size; ++i) {
        // Twice the angle, so that opposite directions are one; strength squared.
        const float real = gx[i] * gx[i] - gy[i] * gy[i], imaginary = 2.0f * gx[i] * gy[i];
        auto number = std::int32_t(gradients::turn(imaginary, real) * float(count) + 0.5f);
        number = number < count ? number : 0;  // half a turn on
        const bool strong = real * real + imaginary * imaginary > least;
        bins[i] = std::uint8_t(strong ? number : count);
    }
}

// Writes the bin of each pixel's edge, as `edge_bins` does, by Sobel's operator.
//
// Ng and Delp, equations 10 and 11; past the border of the image its pixels repeat.
inline void sobel(Picture picture, Index left, Index top, double threshold, int count,
                  Plane<std::uint8_t> bins) {
    const Index height = bins.rows, width = bins.columns;
    ScratchPlane<float> gray(height + 2, width + 2);
    gradients::gray_values(picture, left - 1, top - 1, gray);
    Scratch<float> across(width), down(width);
    float* __restrict gx = across;
    float* __restrict gy = down;
    for (Index i = 0; i < height; ++i) {
        const float *above = gray[i], *here = gray[i + 1], *below = gray[i + 2];
        for (Index j = 0; j < width; ++j) {
            gx[j] = (above[j + 2] - above[j]) + 2.0f * (here[j + 2] - here[j]) +
                    (below[j + 2] - below[j]);
            gy[j] = (below[j] - above[j]) + 2.0f * (below[j + 1] - above[j + 1]) +
                    (below[j + 2] - above[j + 2]);
        }
        edge_bins(gx, gy, width, threshold, count, bins[i]);
    }
}

// Writes the normalized histogram (count + 1,) of strong edges (Ng and Delp, equations 18 and 19).
//
// Its last place is 1 where there is none, else 0; all are 0 where no pixel is seen.
inline void strong(Floats filled, double* histogram) {
    const Index count = filled.size - 1;
    histograms::normalize({filled.data, count}, histogram);
    const bool none =
        std::all_of(filled.begin(), filled.end() - 1, [](double v) { return v == 0.0; });
    histogram[count] = none && filled[count] > 0.0 ? 1.0 : 0.0;
}

// Writes each ellipse's histogram of strong edges from a plane of bins, which begins at left, top.
inline void histograms(Plane<const std::uint8_t> bins, Index left, Index top, Ellipses ellipses,
                       const sampling::Reading& reading, Histograms out) {
    fit(out.rows == ellipses.rows && out.columns > 1, "a histogram for each ellipse");
    histograms::each(
        sampling::window_of(left, top, bins.columns, bins.rows), ellipses, reading, out.columns,
        bins.data, [](Index, histograms::Points points) { return points.offsets; },
        [&](Index n, Floats filled) { strong(filled, out[n]); });
}

// Writes the same histograms without a plane, by Sobel's operator at a lattice's points.
inline void histograms_at(Picture picture, Ellipses ellipses, Plane<const float> lattice,
                          int profile, double threshold, Histograms out) {
    fit(out.rows == ellipses.rows && out.columns > 1, "a histogram for each ellipse");
    static const float smooth[] = {2, 1}, derivative[] = {0, 1};
    const Index room = lattice.columns;
    const gradients::DerivativesAt derivatives(picture, {smooth, 2}, {derivative, 2}, room);
    Scratch<float> gx(room), gy(room);
    Scratch<std::uint8_t> bins(room);
    Scratch<std::uint32_t> keys(room);
    const auto found = [&](Index, histograms::Points points) -> const std::uint32_t* {
        derivatives(points.offsets, points.count, gx, gy);
        edge_bins(gx, gy, points.count, threshold, std::int32_t(out.columns - 1), bins);
        std::copy_n(static_cast<std::uint8_t*>(bins), points.count,
                    static_cast<std::uint32_t*>(keys));
        return keys;
    };
    histograms::each(sampling::window_of(0, 0, picture.width, picture.height), ellipses,
                     {lattice, {1, 1}, profile}, out.columns, histograms::Same(), found,
                     [&](Index n, Floats filled) { strong(filled, out[n]); });
}

}  // namespace motes::sobel
