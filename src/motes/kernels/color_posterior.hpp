// How probable it is that a sample is of the target, by its color of 32x32x32.
#pragma once

#include <algorithm>

#include "arrays.hpp"
#include "gradients.hpp"

namespace motes::color_posterior {

// A box in samples.
struct Box {
    double left, top, right, bottom;
};

// The whole numbers from `first` to before `last`.
struct Span {
    // Those from 0 to before `size` that lie within `low` and `high`.
    Span(double low, double high, Index size)
        : first(Index(limited(std::ceil(low), double(size)))),
          last(std::max(first, Index(limited(std::ceil(high), double(size))))) {}

    bool has(Index i) const { return first <= i && i < last; }
    Index size() const { return last - first; }

    Index first, last;
};

// Writes the numbers of the colors of a row of samples.
inline void write_colors(Samples samples, Index i, std::int32_t* __restrict colors) {
    const float *red = samples[0][i], *green = samples[1][i], *blue = samples[2][i];
    const auto level = [](float value) { return std::int32_t(limited(value, 255.0f)) >> 3; };
    for (Index j = 0; j < samples.columns; ++j)
        colors[j] = (level(red[j]) << 10) + (level(green[j]) << 5) + level(blue[j]);
}

inline void fit_colors(Samples samples, Index inside, Index outside) {
    constexpr Index colors = 32 * 32 * 32;
    fit(samples.planes == 3 && inside == colors && outside == colors,
        "samples (3, H, W), and two rows of 32768 colors");
}

// Adds `share` of 32x32x32 colors: of samples in the box `inner`, and of those not in `outer`, in
// which it lies.
inline void add_colors(Samples samples, Box inner, Box outer, double share, Row<float> inside,
                       Row<float> outside) {
    const Index height = samples.rows, width = samples.columns;
    fit_colors(samples, inside.size, outside.size);
    const Span across(inner.left, inner.right, width), down(inner.top, inner.bottom, height);
    const Span wide(outer.left, outer.right, width), high(outer.top, outer.bottom, height);
    const Index here = across.size() * down.size();
    const Index there = height * width - wide.size() * high.size();
    const float one = float(share / double(std::max(here, Index(1))));
    const float other = float(share / double(std::max(there, Index(1))));
    Scratch<std::int32_t> colors(width);
    for (Index i = 0; i < height; ++i) {
        write_colors(samples, i, colors);
        if (down.has(i))
            for (Index j = across.first; j < across.last; ++j) inside[colors[j]] += one;
        const Index left = high.has(i) ? wide.first : width,
                    right = high.has(i) ? wide.last : width;
        for (Index j = 0; j < left; ++j) outside[colors[j]] += other;
        for (Index j = right; j < width; ++j) outside[colors[j]] += other;
    }
}

// Writes the sums (H + 1, W + 1), above and left of each corner, of inside / (inside + outside).
//
// A color that was never seen counts 1/2.
inline void color_integral(Samples samples, Row<const float> inside, Row<const float> outside,
                           Plane<double> out) {
    const Index width = samples.columns;
    fit_colors(samples, inside.size, outside.size);
    fit(out.rows == samples.rows + 1 && out.columns == width + 1, "sums (H + 1, W + 1)");
    // Loops over arrays, so that all but the reading of colors and the sum becomes vector code.
    Scratch<std::int32_t> colors(width);
    ScratchPlane<float> shares(2, width);
    Scratch<double> scratch(width);
    float* __restrict target = shares[0], * __restrict around = shares[1];
    double* __restrict posterior = scratch;
    std::fill_n(out[0], out.columns, 0.0);
    for (Index i = 0; i < samples.rows; ++i) {
        write_colors(samples, i, colors);
        for (Index j = 0; j < width; ++j)
            target[j] = inside[colors[j]], around[j] = outside[colors[j]];
        for (Index j = 0; j < width; ++j)
            posterior[j] = (double(target[j]) + 1e-6) / (double(target[j] + around[j]) + 2e-6);
        double total = 0.0;
        out[i + 1][0] = 0.0;
        for (Index j = 0; j < width; ++j) {
            total += posterior[j];
            out[i + 1][j + 1] = out[i][j + 1] + total;
        }
    }
}

// Writes the means of 5x5 values; beside the plane its nearest value counts.
inline void local_means(Plane<const float> values, Plane<float> out) {
    constexpr Index reach = 2;
    constexpr float shares[reach + 1] = {0.2f, 0.2f, 0.2f};
    const Index height = values.rows, width = values.columns;
    ScratchPlane<float> padded(height + 2 * reach, width + 2 * reach), rows(padded.rows(), width);
    for (Index i = 0; i < padded.rows(); ++i) {
        const float* from = values[std::clamp<Index>(i - reach, 0, height - 1)];
        float* to = padded[i];
        std::fill_n(to, reach, from[0]);
        std::copy_n(from, width, to + reach);
        std::fill_n(to + reach + width, reach, from[width - 1]);
    }
    const Taps taps{shares, reach + 1};
    gradients::along_rows(gradients::read_only<float>(padded), taps, 1.0f, rows);
    gradients::along_columns(gradients::read_only<float>(rows), taps, 1.0f, out);
}

// Writes three planes in the place of the colors that gray samples lack: the mean of 5x5 samples,
// the sample itself, and four times the mean deviation of 5x5 samples from their means.
inline void texture(Plane<const float> gray, Volume<float> out) {
    fit(out.planes == 3 && same_size(gray, out) && gray.rows > 0 && gray.columns > 0,
        "three planes of the samples' size");
    const Row<const float> samples = gray.flat();
    const Row<float> means = out[0].flat();
    std::copy(samples.begin(), samples.end(), out[1].data);
    local_means(gray, out[0]);
    ScratchPlane<float> differences(gray.rows, gray.columns);
    float* __restrict difference = differences.begin();
    for (Index i = 0; i < samples.size; ++i) difference[i] = 4 * std::abs(samples[i] - means[i]);
    local_means(gradients::read_only<float>(differences), out[2]);
}

}  // namespace motes::color_posterior
