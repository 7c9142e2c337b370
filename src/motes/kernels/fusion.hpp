// The uncertainty of cues: how far the particles that a cue prefers are apart.
#pragma once

#include "particles.hpp"

namespace motes::fusion {

constexpr Index SIZE = 5;  // x, y, a, b, theta

// Returns the logarithm of the determinant of a symmetric, positive definite matrix, by Cholesky.
inline double log_determinant(Plane<double> matrix) {
    double logarithm = 0.0;
    for (Index k = 0; k < SIZE; ++k) {
        const double pivot = matrix[k][k];
        logarithm += std::log(pivot);
        for (Index i = k + 1; i < SIZE; ++i)
            for (Index j = k + 1; j <= i; ++j) matrix[i][j] -= matrix[i][k] * matrix[j][k] / pivot;
    }
    return logarithm;
}

// Writes the logarithm of each cue's uncertainty (J,), from log-likelihoods (J, N) of ellipses:
// Maggio et al., equations 8 and 9.
//
// Each dimension counts in standard deviations of the predicted particles, which weigh `prior`, or
// in its own unit if they are nearer to each other than `equal`. `floor`² times the predicted
// covariance is added, and `singular` to each variance.
inline void log_determinants(Floats prior, Plane<const double> logs, Ellipses ellipses,
                             double floor, double equal, double singular, Row<double> out) {
    fit(prior.size == ellipses.rows && logs.columns == prior.size && out.size == logs.rows,
        "a log-weight of each cue for each ellipse");
    Scratch<double> own(prior.size), weights(prior.size), mean(SIZE);
    ScratchPlane<double> predicted(SIZE, SIZE), covariance(SIZE, SIZE);
    std::copy(prior.begin(), prior.end(), own.begin());
    particles::normalize(own, weights);
    particles::moments(ellipses, weights, mean, predicted);
    double spread[SIZE];
    for (Index i = 0; i < SIZE; ++i) {
        spread[i] = std::sqrt(predicted[i][i]);
        if (spread[i] < equal) spread[i] = 1.0;
    }
    for (Index cue = 0; cue < logs.rows; ++cue) {
        for (Index n = 0; n < prior.size; ++n) own[n] = prior[n] + logs[cue][n];
        particles::normalize(own, weights);
        particles::moments(ellipses, weights, mean, covariance);  // equation 8
        for (Index i = 0; i < SIZE; ++i)
            for (Index j = 0; j < SIZE; ++j) {
                const double sum = covariance[i][j] + floor * floor * predicted[i][j];
                covariance[i][j] = sum / (spread[i] * spread[j]) + (i == j ? singular : 0.0);
            }
        out[cue] = log_determinant(covariance);  // equation 9
    }
}

}  // namespace motes::fusion
