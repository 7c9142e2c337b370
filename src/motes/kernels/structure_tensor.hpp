// Orientation by the structure tensor, and its histograms.
#pragma once

#include "gradients.hpp"
#include "histograms.hpp"

namespace motes::structure_tensor {

// Writes certainty and orientation bin of each block of step x step pixels of a region.
//
// With J the structure tensor (Maggio et al., equation 3), z = J11 - J22 + 2i J12 has
// |z| = lambda_max - lambda_min, and twice the angle of the dominant eigenvector for its own: the
// certainty is |z| trace J (equation 4), the bin one of `count` of equal width over [-pi/2, pi/2).
inline void structure_tensor(Picture picture, Index left, Index top, Index step, Taps smooth,
                             Taps derivative, Taps window, Plane<float> certainty,
                             Plane<std::uint8_t> bins, int count) {
    const Index height = certainty.rows, width = certainty.columns, outer = window.size - 1;
    const Index rows = height + 2 * outer, columns = width + 2 * outer;
    ScratchPlane<float> gx(rows, columns), gy(rows, columns), product(rows, columns);
    gradients::derivatives(picture, left - outer * step, top - outer * step, step, smooth,
                           derivative, gx, gy);
    ScratchPlane<float> narrow(rows, width);
    const auto average = [&](auto of, Plane<float> out) {
        for (Index i = 0; i < rows; ++i) {
            const float *u = gx[i], *v = gy[i];
            float* __restrict line = product[i];
            for (Index j = 0; j < columns; ++j) line[j] = of(u[j], v[j]);
        }
        gradients::along_rows(gradients::read_only<float>(product), window, 1.0f, narrow);
        gradients::along_columns(gradients::read_only<float>(narrow), window, 1.0f, out);
    };
    ScratchPlane<float> real(height, width), imaginary(height, width), trace(height, width);
    average([](float u, float v) { return u * u - v * v; }, real);
    average([](float u, float v) { return 2.0f * u * v; }, imaginary);
    average([](float u, float v) { return u * u + v * v; }, trace);
    for (Index i = 0; i < height; ++i) {
        const float *re = real[i], *im = imaginary[i], *sum = trace[i];
        float* __restrict sure = certainty[i];
        std::uint8_t* __restrict bin = bins[i];
        for (Index j = 0; j < width; ++j) {
            sure[j] = std::sqrt(re[j] * re[j] + im[j] * im[j]) * sum[j];
            // Rounding may give a whole turn, which is none.
            const auto number = std::int32_t(gradients::turn(im[j], re[j]) * float(count));
            bin[j] = std::uint8_t(number < count ? number : 0);
        }
    }
}

// Writes a histogram turned back by `shift` bins, whole or not, smoothed and normalized.
//
// A triangle of two bins to either side, read at the shifted places, does both in one.
inline void turned_back(Floats histogram, double shift, double* out) {
    const Index count = histogram.size;
    double total = 0.0;
    for (const double value : histogram) total += value;
    shift = total > 0.0 ? std::fmod(shift, double(count)) : 0.0;
    const double scale = total > 0.0 ? 0.25 / total : 0.0;
    const auto whole = Index(std::floor(shift));
    const double part = shift - double(whole);
    Index place = (whole % count + count) % count;
    for (Index u = 0; u < count; ++u) {
        const Index before = (place > 0 ? place : count) - 1;
        const Index after = place + 1 < count ? place + 1 : 0;
        const Index last = after + 1 < count ? after + 1 : 0;
        // The triangle at distances 1 + part, part, 1 - part and 2 - part.
        out[u] = scale * ((1.0 - part) * histogram[before] + (2.0 - part) * histogram[place] +
                          (1.0 + part) * histogram[after] + part * histogram[last]);
        place = after;
    }
}

// Writes each ellipse's normalized orientation histogram, zeros where it has no strong edge.
//
// Certainties above `threshold` are cumulated; the histogram is then
// turned back by `shifts` bins and smoothed. The plane begins at left, top, in the ellipses' units.
inline void histograms(Plane<const float> certainty, Plane<const std::uint8_t> bins, Index left,
                       Index top, Ellipses ellipses, const sampling::Reading& reading,
                       double threshold, Floats shifts, Histograms out) {
    fit(bins.rows == certainty.rows && bins.columns == certainty.columns &&
            shifts.size == ellipses.rows && out.rows == ellipses.rows && out.columns > 0,
        "a bin for each certainty, and a shift and a histogram for each ellipse");
    const auto sure = [&](Index, histograms::Points points) {
        for (Index i = 0; i < points.count; ++i) {
            const float value = certainty.data[points.offsets[i]];
            // A branch that goes either way half of the time would take longer than all the rest.
            points.weights[i] *= value * float(value > threshold);
        }
        return points.offsets;
    };
    histograms::each(sampling::window_of(left, top, certainty.columns, certainty.rows), ellipses,
                     reading, out.columns, bins.data, sure,
                     [&](Index n, Floats filled) { turned_back(filled, shifts[n], out[n]); });
}

}  // namespace motes::structure_tensor
