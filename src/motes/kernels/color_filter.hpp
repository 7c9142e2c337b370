// The step of a particle filter that compares colors alone.
//
// It calls the functions that other filters' steps call one by one, in the same order.
#pragma once

#include <numpy/random/bitgen.h>

#include <tuple>
#include <utility>

#include "color.hpp"
#include "particles.hpp"

extern "C" {  // `random` and `standard_normal` of numpy's Generator, in its library npyrandom
void random_standard_uniform_fill(bitgen_t* random, std::ptrdiff_t count, double* out);
void random_standard_normal_fill(bitgen_t* random, std::ptrdiff_t count, double* out);
}

namespace motes::color_filter {

// A likelihood exp(-d² / (2 sigma²)) + epsilon of a distance d.
struct Likelihood {
    double sigma, epsilon;
};

// What particles are compared with, with the names of `ColorComparison` in Python.
struct Comparison {
    color::Target target;
    Likelihood likelihood;
    double threshold;
    bool ring;
};

// What particles see; `degenerate` if none of them had any weight, `distance` that of the estimate,
// `around` the rho beside it, `support` the sum of the weights of the particles that are
// `appearing`.
using Observation = std::tuple<Scratch<double> /* log-weights */, Scratch<double> /* weights */,
                               bool /* degenerate */, std::array<double, 5> /* mean */,
                               ScratchPlane<double> /* covariance */, double /* spread */,
                               double /* effective sample size */, double /* distance */,
                               double /* around */, Index /* appearing */, double /* support */>;
using Outcome = std::tuple<ScratchPlane<double> /* states */, Observation>;

// Writes the regions that AppearanceRule.regions returns, and returns their number.
inline Index write_regions(Picture picture, const std::array<double, 5>& region,
                           std::array<double, 25>& out) {
    const auto [x, y, a, b, theta] = region;
    const double cos = std::cos(theta), sin = std::sin(theta);
    const double right = std::hypot(a * cos, b * sin), down = std::hypot(a * sin, b * cos);
    Index count = 1;
    std::copy_n(region.begin(), 5, out.begin());
    for (int corner = 0; corner < 4; ++corner) {
        const double moved_x = x + (corner % 2 ? right : -right);
        const double moved_y = y + (corner / 2 ? down : -down);
        if (moved_x < 0 || moved_y < 0 || moved_x >= picture.width || moved_y >= picture.height)
            continue;
        const double moved[] = {moved_x, moved_y, a, b, theta};
        std::copy_n(moved, 5, out.begin() + 5 * count++);
    }
    return count;
}

// Weighs particles (N, d) by their colors and estimates the target (Nummiaro et al., figure 2).
inline Observation observe(Picture picture, Plane<const double> states,
                           const Comparison& comparison) {
    const auto& [target, likelihood, threshold, ring] = comparison;
    const Index count = states.rows;
    Scratch<double> distances(count), logs(count), weights(count);
    ScratchPlane<double> covariance(5, 5);
    std::array<double, 5> mean;
    fit(count > 0 && states.columns >= 5, "particles, x, y, a, b, theta and more");
    const Ellipses ellipses{states.data, count, 5, states.columns};  // the first columns
    color::distances(picture, ellipses, target, distances);
    particles::gaussian({distances, 1, count}, {&likelihood.sigma, 1}, likelihood.epsilon,
                        {logs, 1, count});
    const bool degenerate = particles::normalize(logs, weights);
    particles::moments(ellipses, weights, {mean.data(), 5}, covariance);
    std::array<double, 25> regions;
    std::array<double, 5> found;
    const Index read = write_regions(picture, mean, regions), last = ring ? read : 1;
    color::distances(picture, {regions.data(), last, 5, 5}, target, {found.data(), last});
    double around = 0.0;
    for (Index n = 1; n < last; ++n) around += 1.0 - found[n] * found[n];
    if (last > 1) around /= double(last - 1);
    const auto [appearing, support] = particles::appearing(distances, weights, threshold);
    const double spread = particles::spread({covariance.begin(), 5, 5}, {mean[2], mean[3]});
    const double size = particles::effective_sample_size(weights);
    return {std::move(logs),
            std::move(weights),
            degenerate,
            mean,
            std::move(covariance),
            spread,
            size,
            found[0],
            around,
            appearing,
            support};
}

// Selects `count` particles (M, d) by their weights, propagates and observes them: a whole step.
//
// The random numbers are those that `Multinomial` and `Walking` would draw, in their order. No
// other thread may draw from `random` meanwhile.
inline Outcome step(Picture picture, Plane<const double> before, Floats before_weights,
                    bitgen_t* random, Index count, const particles::Noise& noise, double steps,
                    Pair first, const Comparison& comparison) {
    const Index columns = before.columns;
    fit(before_weights.size == before.rows, "a weight for each particle");
    Scratch<Index> chosen(count);
    Scratch<double> positions(count);
    ScratchPlane<double> normal(count, columns + 1), states(count, columns);
    random_standard_uniform_fill(random, count, positions);
    random_standard_normal_fill(random, count * (columns + 1), normal.begin());
    particles::ancestors(before_weights, positions, chosen);
    for (Index n = 0; n < count; ++n) std::copy_n(before[chosen[n]], columns, states[n]);
    particles::walk({states.begin(), count, columns, columns}, {normal.begin(), count, columns + 1},
                    noise, steps, first, states);
    Observation seen = observe(picture, {states.begin(), count, columns}, comparison);
    return {std::move(states), std::move(seen)};
}

}  // namespace motes::color_filter
