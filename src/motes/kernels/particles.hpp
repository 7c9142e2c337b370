// Particles: their motion, selection, weights and mean.
#pragma once

#include <algorithm>
#include <limits>
#include <utility>

#include "arrays.hpp"

namespace motes::particles {

constexpr double PI = 3.14159265358979323846;

// Writes the states (N, 5 + 4k) that follow: x, y, a, b, theta and k orders of their changes.
//
// A column takes its normal number times its deviation, and `steps` times the new value of its
// change. Of a change the share `kept` is left; half-axes keep `kept_size` of their distance, in
// logarithms, to the first ones `a` and `b`, and are then scaled by a common factor, whose
// logarithm is the last normal number times `size_deviation`. They stay at one pixel or more.
inline void walk(Table<const double> states, Plane<const double> normal, Floats deviations,
                 double steps, double kept, double a, double b, double kept_size,
                 double size_deviation, Plane<double> out) {
    const Index columns = states.columns;
    const auto resized = [&](double now, double first, double growth) {
        const double distance = std::log(std::max(now, 1.0) / first);
        return std::max(first * std::exp(kept_size * distance + growth), 1.0);
    };
    for (Index n = 0; n < states.rows; ++n) {
        const double *before = states[n], *noise = normal[n];
        double* after = out[n];
        for (Index i = columns - 1; i > 4; --i) {
            after[i] = kept * before[i] + deviations[i] * noise[i];
            if (i + 4 < columns) after[i] += steps * after[i + 4];
        }
        for (Index i = 0; i < 5; ++i) {
            after[i] = before[i] + deviations[i] * noise[i];
            if (i < 4 && columns > 5) after[i] += steps * after[i + 5];
        }
        const double growth = size_deviation * noise[columns];
        after[2] = resized(after[2], a, growth);
        after[3] = resized(after[3], b, growth);
    }
}

// Writes, for each position from 0 to 1, the first particle whose cumulated weight exceeds it.
//
// Positions are shares of the sum of weights; a particle without weight is never chosen, if any has
// one.
inline void ancestors(Floats weights, Floats positions, Row<Index> chosen) {
    Scratch<double> cumulated(weights.size);
    double total = 0.0;
    Index last = 0;
    for (Index n = 0; n < weights.size; ++n) {
        total += weights[n];
        cumulated[n] = total;
        if (weights[n] > 0.0) last = n;
    }
    for (Index i = 0; i < positions.size; ++i) {
        // Rounding may lift the largest position onto the last sum, so that one is not searched.
        const double* begin = cumulated;
        chosen[i] = std::upper_bound(begin, begin + last, positions[i] * total) - begin;
    }
}

// Writes log(exp(-d² / (2 sigma²)) + epsilon) of distances (J, N) and sigmas (J,).
inline void gaussian(Plane<const double> distances, Floats sigmas, double epsilon,
                     Plane<double> logs) {
    for (Index j = 0; j < distances.rows; ++j) {
        const double scale = -0.5 / (sigmas[j] * sigmas[j]);
        for (Index n = 0; n < distances.columns; ++n) {
            const double log = scale * distances[j][n] * distances[j][n];
            logs[j][n] = epsilon > 0.0 ? std::log(std::exp(log) + epsilon) : log;
        }
    }
}

// Writes probabilities for log-weights, whose NaN and +inf become -inf; returns true if none has
// any. They are then uniform.
inline bool normalize(Row<double> logs, Row<double> values) {
    constexpr double inf = std::numeric_limits<double>::infinity();
    double top = -inf;
    for (double& log : logs) {
        if (!(log < inf)) log = -inf;
        top = std::max(top, log);
    }
    if (top == -inf) {
        std::fill(values.begin(), values.end(), 1.0 / double(logs.size));
        return true;
    }
    double total = 0.0;
    for (Index n = 0; n < logs.size; ++n) total += values[n] = std::exp(logs[n] - top);
    for (Index n = 0; n < logs.size; ++n) values[n] /= total;
    return false;
}

// Writes the root of the mean of the squared distances (J, N) of cues by their shares (J,).
inline void combine(Plane<const double> distances, Floats shares, Row<double> out) {
    for (Index n = 0; n < out.size; ++n) {
        double sum = 0.0;
        for (Index j = 0; j < distances.rows; ++j)
            sum += shares[j] * distances[j][n] * distances[j][n];
        out[n] = std::sqrt(sum);
    }
}

// Returns how many particles have a rho, 1 - d², above a threshold, and the sum of weights.
inline std::pair<Index, double> appearing(Floats distances, Floats weights, double threshold) {
    Index count = 0;
    double support = 0.0;
    for (Index n = 0; n < distances.size; ++n) {
        if (1.0 - distances[n] * distances[n] > threshold) {
            ++count;
            support += weights[n];
        }
    }
    return {count, support};
}

// Writes the weighted mean (5,) and covariance (5, 5) of ellipses, angles modulo pi.
inline void moments(Ellipses ellipses, Floats weights, Row<double> mean, Plane<double> covariance) {
    std::fill(mean.begin(), mean.end(), 0.0);
    std::fill_n(covariance.data, 25, 0.0);
    double sin = 0.0, cos = 0.0;
    for (Index n = 0; n < ellipses.rows; ++n) {
        const double* ellipse = ellipses[n];
        for (Index i = 0; i < 4; ++i) mean[i] += weights[n] * ellipse[i];
        sin += weights[n] * std::sin(2 * ellipse[4]);
        cos += weights[n] * std::cos(2 * ellipse[4]);
    }
    mean[4] = std::atan2(sin, cos) / 2;
    for (Index n = 0; n < ellipses.rows; ++n) {
        double off[5];
        for (Index i = 0; i < 5; ++i) off[i] = ellipses[n][i] - mean[i];
        off[4] -= PI * std::nearbyint(off[4] / PI);
        for (Index i = 0; i < 5; ++i)
            for (Index j = 0; j <= i; ++j) covariance[i][j] += weights[n] * off[i] * off[j];
    }
    for (Index i = 0; i < 5; ++i)
        for (Index j = 0; j < i; ++j) covariance[j][i] = covariance[i][j];
}

}  // namespace motes::particles
