// The step of a particle filter that compares colors alone.
//
// It calls the functions that other filters' steps call one by one, in the same order.
#pragma once

#include <tuple>
#include <utility>

#include "color.hpp"
#include "particles.hpp"

namespace motes::color_filter {

// A likelihood exp(-d² / (2 sigma²)) + epsilon of a distance d.
struct Likelihood {
    double sigma, epsilon;
};

// What particles see; `degenerate` if none of them had any weight, `distance` that of the estimate,
// `support` the sum of the weights of the particles that are `appearing`.
using Observation =
    std::tuple<Scratch<double> /* distances */, Scratch<double> /* log-weights */,
               Scratch<double> /* weights */, bool /* degenerate */,
               std::array<double, 5> /* mean */, ScratchPlane<double> /* covariance */,
               double /* distance */, Index /* appearing */, double /* support */>;
using Outcome = std::tuple<ScratchPlane<double> /* states */, Observation>;

// Weighs particles (N, d) by their colors and estimates the target (Nummiaro et al., figure 2).
//
// A particle appears if its rho is above `threshold`.
inline Observation observe(Picture picture, Plane<const double> states, const color::Target& target,
                           Likelihood likelihood, double threshold) {
    const Index count = states.rows;
    Scratch<double> distances(count), logs(count), weights(count);
    ScratchPlane<double> covariance(5, 5);
    std::array<double, 5> mean;
    const Ellipses ellipses{states.data, count, 5, states.columns};  // the first columns
    color::distances(picture, ellipses, target, distances);
    particles::gaussian({distances, 1, count}, {&likelihood.sigma, 1}, likelihood.epsilon,
                        {logs, 1, count});
    const bool degenerate = particles::normalize(logs, weights);
    particles::moments(ellipses, weights, {mean.data(), 5}, covariance);
    double distance;
    color::distances(picture, {mean.data(), 1, 5, 5}, target, {&distance, 1});
    const auto [appearing, support] = particles::appearing(distances, weights, threshold);
    return {std::move(distances),  std::move(logs), std::move(weights), degenerate, mean,
            std::move(covariance), distance,        appearing,          support};
}

// Selects particles (M, d) with their weights, propagates them, and observes: a whole step.
//
// `positions` (N,) from 0 to 1 select, `normal` (N, d + 1) moves.
inline Outcome step(Picture picture, Plane<const double> before, Floats before_weights,
                    Floats positions, Plane<const double> normal, const particles::Noise& noise,
                    double steps, Pair first, const color::Target& target, Likelihood likelihood,
                    double threshold) {
    const Index count = positions.size, columns = before.columns;
    Scratch<Index> chosen(count);
    ScratchPlane<double> selected(count, columns), states(count, columns);
    particles::ancestors(before_weights, positions, chosen);
    for (Index n = 0; n < count; ++n) std::copy_n(before[chosen[n]], columns, selected[n]);
    particles::walk({selected.begin(), count, columns, columns}, normal, noise, steps, first,
                    states);
    Observation seen =
        observe(picture, {states.begin(), count, columns}, target, likelihood, threshold);
    return {std::move(states), std::move(seen)};
}

}  // namespace motes::color_filter
