// Histograms of color, their distance, and mean shift on them.
#pragma once

#include "histograms.hpp"

namespace motes::color {

enum Space : int { RGB, HSV, HSV_V };

// A color space and its bins in each channel, equally wide.
//
// A pixel's bin is (i0 n1 + i1) n2 + i2; in HSV_V it is i0 n1 + i1 for a pixel with color, and
// n0 n1 + i2 for one without (Zhao and Pei, section 2.1). Kernels map these bins by `slots` to the
// places of a histogram that holds only the bins wanted, its last place taking all others.
struct Bins {
    int space;
    std::uint32_t n0, n1, n2;
};

// Returns the bin of a color, r + 256 g + 65536 b, in RGB.
inline std::uint32_t rgb_bin(std::uint32_t color, const Bins& bins) {
    const std::uint32_t i0 = ((color & 255) * bins.n0) >> 8;
    const std::uint32_t i1 = (((color >> 8) & 255) * bins.n1) >> 8;
    return (i0 * bins.n1 + i1) * bins.n2 + (((color >> 16) * bins.n2) >> 8);
}

// Returns the bin of a color in HSV or HSV_V, without branches.
//
// In HSV, channels run from 0 to 1, gray has hue 0. Hue and saturation are fractions of small
// integers, whose quotient in single precision is never rounded onto or over the next integer: bins
// are exact. A pixel has color in HSV_V where saturation is above 0.1 and value above 0.2.
template <Space space>
std::uint32_t hsv_bin(std::uint32_t color, const Bins& bins) {
    const float r = float(std::int32_t(color & 255));
    const float g = float(std::int32_t((color >> 8) & 255));
    const float b = float(std::int32_t(color >> 16));
    const float high = std::max(r, std::max(g, b));
    const float spread = high - std::min(r, std::min(g, b));
    // Six times the hue, times the spread.
    float hue = 4.0f * spread + r - g;
    hue = high == g ? 2.0f * spread + b - r : hue;
    hue = high == r ? g - b : hue;
    hue = hue < 0.0f ? hue + 6.0f * spread : hue;
    const bool gray = spread == 0.0f;
    const float n0 = float(std::int32_t(bins.n0)), n1 = float(std::int32_t(bins.n1));
    const auto i0 = std::int32_t(hue * n0 / (gray ? 1.0f : 6.0f * spread));
    const auto i1 = std::int32_t(spread * n1 / (gray ? 1.0f : high));
    const std::uint32_t pair =
        std::uint32_t(i0) * bins.n1 + std::min(std::uint32_t(i1), bins.n1 - 1);
    const std::uint32_t i2 = (std::uint32_t(std::int32_t(high)) * bins.n2) >> 8;
    if constexpr (space == HSV) return pair * bins.n2 + i2;
    const bool colored = (10.0f * spread > high) & (high > 51.0f);
    return colored ? pair : bins.n0 * bins.n1 + i2;
}

template <std::uint32_t (*bin)(std::uint32_t, const Bins&)>
void replace(std::uint32_t* __restrict colors, Index count, const Bins bins) {
    for (Index i = 0; i < count; ++i) colors[i] = bin(colors[i], bins);
}

// Refuses slots that are not one for each bin, or beyond a histogram of `size` places.
inline void fit_slots(const Bins& bins, Row<const std::uint32_t> slots, Index size) {
    const Index pairs = Index(bins.n0) * bins.n1;
    const Index count = bins.space == HSV_V ? pairs + bins.n2 : pairs * bins.n2;
    std::uint32_t most = 0;
    for (const std::uint32_t slot : slots) most = std::max(most, slot);
    fit(bins.space >= RGB && bins.space <= HSV_V && count > 0 && slots.size == count &&
            Index(most) < size,
        "a slot for each bin of the color space, within the histogram: a model of these bins");
}

// Replaces colors, as `colors_at` writes them, by their bins: vector code.
inline void to_bins(std::uint32_t* colors, Index count, const Bins& bins) {
    if (bins.space == RGB) replace<rgb_bin>(colors, count, bins);
    if (bins.space == HSV) replace<hsv_bin<HSV>>(colors, count, bins);
    if (bins.space == HSV_V) replace<hsv_bin<HSV_V>>(colors, count, bins);
}

// As `histograms::each`, with the color of each pixel.
template <typename Write>
void each(Picture picture, Ellipses ellipses, const sampling::Reading& reading,
          Row<const std::uint32_t> slots, Bins bins, Index size, Write write) {
    fit_slots(bins, slots, size);
    const sampling::Window window = sampling::window_of(picture);
    Scratch<std::uint32_t> colors(sampling::capacity(window, ellipses, reading));
    const auto keys = [&](Index, histograms::Points points) -> const std::uint32_t* {
        sampling::colors_at(picture, points.offsets, points.count, colors);
        to_bins(colors, points.count, bins);
        return colors;
    };
    histograms::each(window, ellipses, reading, size, slots.data, keys, write);
}

// Writes each ellipse's normalized histogram (Nummiaro et al., equation 3): in bin u, the sum of
// the weights of the pixels whose color is in it. Zeros where an ellipse sees no pixel.
inline void histograms(Picture picture, Ellipses ellipses, const sampling::Reading& reading,
                       Row<const std::uint32_t> slots, Bins bins, Histograms out) {
    fit(out.rows == ellipses.rows, "a histogram for each ellipse");
    each(picture, ellipses, reading, slots, bins, out.columns,
         [&](Index n, Floats histogram) { histograms::normalize(histogram, out[n]); });
}

// A target model, and how ellipses are read that are compared with it.
//
// `roots` holds the square roots of the model's occupied bins, which alone can add to the sum.
struct Target {
    sampling::Reading reading;
    Row<const std::uint32_t> slots;
    Floats roots;
    Bins bins;
};

// Writes each ellipse's Bhattacharyya distance to a target model (equations 6 and 7).
//
// An ellipse that sees no pixel is at distance 1.
inline void distances(Picture picture, Ellipses ellipses, const Target& target, Row<double> out) {
    const auto& [reading, slots, roots, bins] = target;
    fit(out.size == ellipses.rows, "a distance for each ellipse");
    each(picture, ellipses, reading, slots, bins, roots.size + 1,
         [&, &roots = roots](Index n, Floats histogram) {
             out[n] = histograms::distance(histograms::coefficient(roots, histogram));
         });
}

// Writes the mean (x, y) of an ellipse's pixels, each weighted by its bin's entry in `ratios`
// (Comaniciu, Ramesh and Meer, equations 10 and 11, with the Epanechnikov kernel).
//
// Leaves `center` as it is where no pixel has any weight.
inline void mean_shift(Picture picture, Floats ellipse, Plane<const float> lattice,
                       sampling::Grid grid, Row<const std::uint32_t> slots, Floats ratios,
                       Bins bins, Row<double> center) {
    const sampling::Window window = sampling::window_of(picture);
    const sampling::Reading reading{lattice, grid, sampling::EPANECHNIKOV};
    fit(ellipse.size >= 5 && center.size >= 2, "an ellipse, and its center");
    fit_slots(bins, slots, ratios.size);
    const Index room =
        sampling::capacity(window, {ellipse.data, 1, ellipse.size, ellipse.size}, reading);
    Scratch<std::uint32_t> offsets(room), colors(room);
    Scratch<double> weights(room);
    const Index count = sampling::pixels_within(window, ellipse.data, reading, offsets, weights);
    sampling::colors_at(picture, offsets, count, colors);
    to_bins(colors, count, bins);
    double total = 0.0, sum_x = 0.0, sum_y = 0.0;
    for (Index i = 0; i < count; ++i) {
        if (weights[i] > 0.0) {
            const double weight = ratios[slots[colors[i]]];
            const auto line = std::uint32_t(window.line), pixel = std::uint32_t(window.pixel);
            total += weight;
            sum_x += weight * double(offsets[i] % line / pixel);
            sum_y += weight * double(offsets[i] / line);
        }
    }
    if (total > 0.0) center[0] = sum_x / total, center[1] = sum_y / total;
}

}  // namespace motes::color
