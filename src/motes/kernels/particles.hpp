// Particles: their motion, selection, weights and mean.
#pragma once

#include <algorithm>
#include <limits>
#include <tuple>

#include "arrays.hpp"

namespace motes::particles {

constexpr double PI = 3.14159265358979323846;

// Random motion in one reference interval, with the names of `Noise` and `Walking` in Python's
// `motion`.
struct Noise {
    double position, size, size_return, aspect, angle;
    Floats changes;      // deviations of each order of changes, as shares of what they change
    double persistence;  // share of a change that is left
};

// Writes the states (N, 5 + 4k) that follow: x, y, a, b, theta and k orders of their changes, such
// as velocities, `steps` reference intervals later.
//
// `normal` has a number for each column, and a last one for the factor common to both half-axes,
// which return to the first ones. They stay at one pixel or more. `out` may be `states`.
inline void walk(Table<const double> states, Plane<const double> normal, const Noise& noise,
                 double steps, Pair first, Plane<double> out) {
    const Index columns = states.columns, orders = noise.changes.size;
    fit(columns == 5 + 4 * orders && out.columns == columns && out.rows == states.rows &&
            normal.rows == states.rows && normal.columns == columns + 1,
        "states (N, 5 + 4 k) of the model's k orders, and numbers (N, 6 + 4 k)");
    const double grown = std::sqrt(steps);
    const double mean = std::sqrt(first.x * first.y);  // a narrow target moves as fast sideways
    const double position = mean * noise.position * grown, aspect = noise.aspect * grown;
    const double spread[4] = {position, position, first.x * aspect, first.y * aspect};
    Scratch<double> deviations(columns);
    std::copy_n(spread, 4, deviations.begin());
    deviations[4] = noise.angle * grown;
    for (Index i = 5; i < columns; ++i)
        deviations[i] = noise.changes[(i - 5) / 4] * spread[(i - 5) % 4];
    const double kept = std::pow(noise.persistence, steps);
    const double kept_size = std::pow(1 - noise.size_return, steps);
    const auto resized = [&](double now, double half, double growth) {
        const double distance = std::log(std::max(now, 1.0) / half);
        return std::max(half * std::exp(kept_size * distance + growth), 1.0);
    };
    for (Index n = 0; n < states.rows; ++n) {
        const double *before = states[n], *random = normal[n];
        double* after = out[n];
        for (Index i = columns - 1; i > 4; --i) {
            after[i] = kept * before[i] + deviations[i] * random[i];
            if (i + 4 < columns) after[i] += steps * after[i + 4];
        }
        for (Index i = 0; i < 5; ++i) {
            after[i] = before[i] + deviations[i] * random[i];
            if (i < 4 && columns > 5) after[i] += steps * after[i + 5];
        }
        const double growth = noise.size * grown * random[columns];
        after[2] = resized(after[2], first.x, growth);
        after[3] = resized(after[3], first.y, growth);
    }
}

// Returns how many of some values in order are at most `most`, without branches: random ones would
// be foretold wrongly.
inline Index count_up_to(const double* values, Index size, double most) {
    const double* from = values;
    for (; size > 1; size -= size / 2) from += size / 2 * Index(from[size / 2 - 1] <= most);
    return from - values + Index(size == 1 && *from <= most);
}

// Writes, for each position from 0 to 1, the first particle whose cumulated weight exceeds it.
//
// Positions are shares of the sum of weights; a particle without weight is never chosen, if any has
// one.
inline void ancestors(Floats weights, Floats positions, Row<Index> chosen) {
    fit(weights.size > 0 && chosen.size == positions.size, "one weight at least");
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
        chosen[i] = count_up_to(cumulated, last, positions[i] * total);
    }
}

// Writes log(exp(-d² / (2 sigma²)) + epsilon) of distances (J, N) and sigmas (J,).
inline void gaussian(Plane<const double> distances, Floats sigmas, double epsilon,
                     Plane<double> logs) {
    fit(sigmas.size == distances.rows && logs.rows == distances.rows &&
            logs.columns == distances.columns,
        "a sigma for each row of distances");
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
    fit(logs.size > 0 && values.size == logs.size, "one log-weight at least");
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

// Returns 1 / sum of squared weights, in four sums side by side.
inline double effective_sample_size(Floats weights) {
    double sums[4] = {};
    for (Index n = 0; n < weights.size; ++n) sums[n % 4] += weights[n] * weights[n];
    return 1.0 / ((sums[0] + sums[1]) + (sums[2] + sums[3]));
}

// Writes the root of the mean of the squared distances (J, N) of cues by their shares (J,).
inline void combine(Plane<const double> distances, Floats shares, Row<double> out) {
    fit(shares.size == distances.rows && out.size == distances.columns,
        "a share for each row of distances");
    for (Index n = 0; n < out.size; ++n) {
        double sum = 0.0;
        for (Index j = 0; j < distances.rows; ++j)
            sum += shares[j] * distances[j][n] * distances[j][n];
        out[n] = std::sqrt(sum);
    }
}

// Returns how many particles have a rho, 1 - d², above a threshold, and the sum of weights.
inline std::tuple<Index, double> appearing(Floats distances, Floats weights, double threshold) {
    fit(weights.size == distances.size, "a weight for each distance");
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
    fit(weights.size == ellipses.rows && mean.size == 5 && covariance.rows == 5 &&
            covariance.columns == 5,
        "a weight for each ellipse");
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

// Returns the standard deviation of places by their covariance, in mean half-axes of an ellipse.
inline double spread(Plane<const double> covariance, Pair half) {
    fit(covariance.rows >= 2 && covariance.columns >= 2, "the covariance of x and y");
    const double xx = covariance[0][0], xy = covariance[0][1], yy = covariance[1][1];
    const double area = std::sqrt(std::max(xx * yy - xy * xy, 0.0));  // without the factor pi
    return std::sqrt(area / (half.x * half.y));
}

}  // namespace motes::particles
