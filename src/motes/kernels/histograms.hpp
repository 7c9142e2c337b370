// Histograms of the pixels in ellipses: how they are filled, and their distance.
#pragma once

#include "sampling.hpp"

namespace motes::histograms {

constexpr Index LANES = 4;

// Adds each pixel's weight to the slot of its key in a histogram, which is then in lane 0.
//
// `slots` maps a key to a place in the histogram. Neighbors often share a slot; adding them in turn
// to four lanes keeps one addition from waiting for the one before.
template <typename Slots>
void fill(const std::uint32_t* __restrict keys, const double* __restrict weights, Index count,
          Slots slots, Plane<double> lanes) {
    std::fill_n(lanes.data, LANES * lanes.columns, 0.0);
    double *first = lanes[0], *second = lanes[1], *third = lanes[2], *fourth = lanes[3];
    const Index whole = count - count % LANES;
    for (Index i = 0; i < whole; i += LANES) {
        first[slots[keys[i]]] += weights[i];
        second[slots[keys[i + 1]]] += weights[i + 1];
        third[slots[keys[i + 2]]] += weights[i + 2];
        fourth[slots[keys[i + 3]]] += weights[i + 3];
    }
    for (Index i = whole; i < count; ++i) first[slots[keys[i]]] += weights[i];
    for (Index slot = 0; slot < lanes.columns; ++slot)
        first[slot] += second[slot] + third[slot] + fourth[slot];
}

// Slots for keys that are themselves places in the histogram.
struct Same {
    std::uint32_t operator[](std::uint32_t key) const { return key; }
};

// The points of an ellipse that are read: their places, and weights, which may be changed.
struct Points {
    const std::uint32_t* offsets;
    double* weights;
    Index count;
};

// Fills a histogram of `bins` for each ellipse: the loop that all cues share.
//
// `keys(n, points)` returns a key for each point of ellipse n, and `write(n, histogram)` takes what
// `fill` made of them. Both are known when this is compiled, and cost no call.
template <typename Slots, typename Keys, typename Write>
void each(sampling::Window window, Ellipses ellipses, const sampling::Reading& reading, Index bins,
          Slots slots, Keys keys, Write write) {
    const Index room = sampling::capacity(window, ellipses, reading);
    Scratch<std::uint32_t> offsets(room);
    Scratch<double> weights(room);
    ScratchPlane<double> lanes(LANES, bins);
    for (Index n = 0; n < ellipses.rows; ++n) {
        const Index count = sampling::pixels_within(window, ellipses[n], reading, offsets, weights);
        const std::uint32_t* found = keys(n, Points{offsets, weights, count});
        fill(found, weights, count, slots, lanes);
        write(n, Floats{lanes[0], bins});
    }
}

// Writes values divided by their sum; zeros where that is zero.
inline void normalize(Floats values, double* out) {
    double total = 0.0;
    for (const double value : values) total += value;
    for (Index i = 0; i < values.size; ++i) out[i] = total > 0.0 ? values[i] / total : 0.0;
}

// Returns the Bhattacharyya coefficient rho = sum sqrt(p q) of a model, by its square roots
// sqrt(q), with a histogram p that is not normalized (Nummiaro et al., equation 6).
//
// The histogram may go on behind the model's last bin; the coefficient is 0 if it is empty. Four
// sums side by side, added up in the end, become vector code.
inline double coefficient(Floats roots, Floats histogram) {
    double products[4] = {}, sums[4] = {};
    const Index whole = roots.size - roots.size % 4;
    for (Index u = 0; u < whole; u += 4) {
        for (Index k = 0; k < 4; ++k) {
            products[k] += roots[u + k] * std::sqrt(histogram[u + k]);
            sums[k] += histogram[u + k];
        }
    }
    for (Index u = whole; u < roots.size; ++u) products[0] += roots[u] * std::sqrt(histogram[u]);
    for (Index u = whole; u < histogram.size; ++u) sums[0] += histogram[u];
    const double rho = (products[0] + products[1]) + (products[2] + products[3]);
    const double total = (sums[0] + sums[1]) + (sums[2] + sums[3]);
    return total > 0.0 ? rho / std::sqrt(total) : 0.0;
}

// Returns the distance sqrt(1 - rho) for a coefficient (equation 7).
inline double distance(double rho) {
    return std::sqrt(std::max(0.0, 1.0 - rho));
}

// Writes the distances of histograms (N, m) to a model, by its square roots.
inline void bhattacharyya(Plane<const double> histograms, Floats roots, Row<double> distances) {
    fit(roots.size <= histograms.columns && distances.size == histograms.rows,
        "histograms with the bins of the model, and a distance for each");
    for (Index n = 0; n < histograms.rows; ++n)
        distances[n] = distance(coefficient(roots, histograms.row(n)));
}

}  // namespace motes::histograms
