// Fourier transforms of lines, which go through it side by side, one in each lane of a vector.
//
// Factors are taken and sums are made in the order of FFTPACK (Swarztrauber, Vectorizing the FFTs,
// 1982) and of those that follow it, as `scipy.fft` does: results are the same to the last bit,
// whatever the width of vectors.
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "arrays.hpp"

namespace motes::fourier {

#if defined(__AVX2__)
constexpr Index LANES = 8;
#else
constexpr Index LANES = 4;
#endif

#if defined(__GNUC__)
using Lanes = float __attribute__((vector_size(LANES * sizeof(float))));
#else
struct Lanes {
    float values[LANES];
    float& operator[](Index i) { return values[i]; }
    float operator[](Index i) const { return values[i]; }
};
template <typename Operation>
Lanes each(Operation operation) {
    Lanes out;
    for (Index i = 0; i < LANES; ++i) out[i] = operation(i);
    return out;
}
inline Lanes operator+(Lanes a, Lanes b) {
    return each([&](Index i) { return a[i] + b[i]; });
}
inline Lanes operator-(Lanes a, Lanes b) {
    return each([&](Index i) { return a[i] - b[i]; });
}
inline Lanes operator-(Lanes a) {
    return each([&](Index i) { return -a[i]; });
}
inline Lanes operator*(float a, Lanes b) {
    return each([&](Index i) { return a * b[i]; });
}
#endif

struct Numbers {  // complex ones
    Lanes r, i;
};
inline Numbers operator+(const Numbers& a, const Numbers& b) {
    return {a.r + b.r, a.i + b.i};
}
inline Numbers operator-(const Numbers& a, const Numbers& b) {
    return {a.r - b.r, a.i - b.i};
}
inline Numbers operator*(float a, const Numbers& b) {
    return {a * b.r, a * b.i};
}

constexpr float SIN_60 = 0.86602540378443864676f, SIN_45 = 0.70710678118654752440f;
constexpr float COS_72 = 0.30901699437494742410f, SIN_72 = 0.95105651629515357212f;
constexpr float COS_144 = -0.80901699437494742410f, SIN_144 = 0.58778525229247312917f;
constexpr float SQRT_2 = 1.41421356237309504880f;

// The n-th roots of unity, root[k] = exp(2 pi i k / n) for k < n: products of two from short
// tables, which have some sqrt(n) sines each.
class Roots {
public:
    explicit Roots(Index n) : n_(n) {
        const Index half = n / 2 + 1;
        while (step_ * step_ < half) step_ *= 2;
        for (Index k = 0; k < step_; ++k) fine_.push_back(exact(k));
        for (Index k = 0; k * step_ < half; ++k) coarse_.push_back(exact(k * step_));
    }
    Complex operator[](Index k) const {
        const bool below = 2 * k > n_;
        const Index i = below ? n_ - k : k;
        const auto [a, b] = fine_[std::size_t(i % step_)];
        const auto [c, d] = coarse_[std::size_t(i / step_)];
        const double sine = a * d + b * c;
        return {float(a * c - b * d), float(below ? -sine : sine)};
    }

private:
    // Returns cosine and sine of up to a half turn, from an angle of an eighth turn at most.
    std::pair<double, double> exact(Index k) const {
        const double unit = 0.78539816339744830962 / double(n_);
        const Index x = 8 * k, quarter = 2 * n_;
        if (x > quarter) {
            const auto [a, b] = within(x - quarter, unit);
            return {-b, a};
        }
        return within(x, unit);
    }
    std::pair<double, double> within(Index x, double unit) const {
        if (x < n_) return {std::cos(double(x) * unit), std::sin(double(x) * unit)};
        const double rest = double(2 * n_ - x) * unit;
        return {std::sin(rest), std::cos(rest)};
    }

    Index n_, step_ = 1;
    std::vector<std::pair<double, double>> fine_, coarse_;
};

// Complex numbers of a line times the conjugates of roots forward (turn -1), and times roots back.
template <int turn>
Numbers turned(const Numbers& x, Complex root) {
    const float a = root.real(), b = root.imag();
    if (turn < 0) return {a * x.r + b * x.i, a * x.i - b * x.r};
    return {a * x.r - b * x.i, b * x.r + a * x.i};
}
template <int turn>
Numbers quarter(const Numbers& x) {
    return turn < 0 ? Numbers{x.i, -x.r} : Numbers{-x.i, x.r};
}
template <int turn>
Numbers eighth(const Numbers& x) {
    if (turn < 0) return {SIN_45 * (x.r + x.i), SIN_45 * (x.i - x.r)};
    return {SIN_45 * (x.r - x.i), SIN_45 * (x.i + x.r)};
}
inline void cross(Numbers& a, Numbers& b) {
    const Numbers sum = a + b;
    b = a - b;
    a = sum;
}

// The transform of a few numbers in place.
template <Index factor, int turn>
[[gnu::always_inline]] inline void butterfly(Numbers* x) {
    if constexpr (factor == 2) {
        cross(x[0], x[1]);
    } else if constexpr (factor == 3) {
        constexpr float s = turn * SIN_60;
        const Numbers sum = x[1] + x[2], off = x[1] - x[2];
        const Numbers a = x[0] + -0.5f * sum, b{-(s * off.i), s * off.r};
        x[0] = x[0] + sum;
        x[1] = a + b;
        x[2] = a - b;
    } else if constexpr (factor == 4) {
        cross(x[0], x[2]);
        cross(x[1], x[3]);
        const Numbers a = x[0], b = x[2], c = x[1], d = quarter<turn>(x[3]);
        x[0] = a + c;
        x[1] = b + d;
        x[2] = a - c;
        x[3] = b - d;
    } else if constexpr (factor == 5) {
        constexpr float s = turn * SIN_72, t = turn * SIN_144;
        cross(x[1], x[4]);
        cross(x[2], x[3]);
        const Numbers a = x[1], b = x[2], c = x[3], d = x[4];
        const Numbers near = x[0] + COS_72 * a + COS_144 * b;
        const Numbers far = x[0] + COS_144 * a + COS_72 * b;
        const Numbers up{-(s * d.i + t * c.i), s * d.r + t * c.r};
        const Numbers down{-(t * d.i - s * c.i), t * d.r - s * c.r};
        x[0] = x[0] + a + b;
        x[1] = near + up;
        x[2] = far + down;
        x[3] = far - down;
        x[4] = near - up;
    } else {
        Numbers even[] = {x[0], x[2], x[4], x[6]}, odd[] = {x[1], x[3], x[5], x[7]};
        butterfly<4, turn>(even);
        butterfly<4, turn>(odd);
        const Numbers turns[] = {odd[0], eighth<turn>(odd[1]), quarter<turn>(odd[2]),
                                 quarter<turn>(eighth<turn>(odd[3]))};
        for (Index j = 0; j < 4; ++j) {
            x[j] = even[j] + turns[j];
            x[j + 4] = even[j] - turns[j];
        }
    }
}

// The transform of a few real numbers in place: r0, r1, i1, r2, … of its first half.
template <Index factor>
void halve(Lanes* x) {
    if constexpr (factor == 2) {
        const Lanes a = x[0], b = x[1];
        x[0] = a + b;
        x[1] = a - b;
    } else if constexpr (factor == 3) {
        const Lanes sum = x[1] + x[2], off = x[2] - x[1];
        x[1] = x[0] + -0.5f * sum;
        x[0] = x[0] + sum;
        x[2] = SIN_60 * off;
    } else if constexpr (factor == 4) {
        const Lanes a = x[0] + x[2], b = x[3] + x[1], c = x[3] - x[1];
        x[1] = x[0] - x[2];
        x[2] = c;
        x[0] = a + b;
        x[3] = a - b;
    } else {
        const Lanes a = x[4] + x[1], b = x[3] + x[2], c = x[3] - x[2], d = x[4] - x[1];
        x[1] = x[0] + COS_72 * a + COS_144 * b;
        x[2] = SIN_72 * d + SIN_144 * c;
        x[3] = x[0] + COS_144 * a + COS_72 * b;
        x[4] = SIN_144 * d - SIN_72 * c;
        x[0] = x[0] + a + b;
    }
}

// The way back from `halve`, times the factor.
template <Index factor>
void whole(Lanes* x) {
    if constexpr (factor == 2) {
        halve<2>(x);
    } else if constexpr (factor == 3) {
        const Lanes twice = x[1] + x[1], a = x[0] + -0.5f * twice;
        const Lanes b = 2.0f * SIN_60 * x[2];
        x[0] = x[0] + twice;
        x[1] = a - b;
        x[2] = a + b;
    } else if constexpr (factor == 4) {
        const Lanes a = x[0] + x[3], b = x[0] - x[3], c = x[1] + x[1], d = x[2] + x[2];
        x[0] = a + c;
        x[1] = b - d;
        x[2] = a - c;
        x[3] = b + d;
    } else {
        const Lanes a = x[1] + x[1], b = x[3] + x[3], d = x[2] + x[2], c = x[4] + x[4];
        const Lanes near = x[0] + COS_72 * a + COS_144 * b;
        const Lanes far = x[0] + COS_144 * a + COS_72 * b;
        const Lanes up = SIN_72 * d + SIN_144 * c, down = SIN_144 * d - SIN_72 * c;
        x[0] = x[0] + a + b;
        x[1] = near - up;
        x[2] = far - down;
        x[3] = far + down;
        x[4] = near + up;
    }
}

// The same where the roots are half a step on: of two or four, r0, i0, r1, i1.
template <Index factor>
void halve_between(Lanes* x) {
    if constexpr (factor == 2) {
        x[1] = -x[1];
    } else {
        const Lanes a = SIN_45 * (x[1] - x[3]), b = -SIN_45 * (x[1] + x[3]), c = x[2];
        x[1] = b - c;
        x[3] = b + c;
        x[2] = x[0] - a;
        x[0] = x[0] + a;
    }
}
template <Index factor>
void whole_between(Lanes* x) {
    if constexpr (factor == 2) {
        x[0] = 2.0f * x[0];
        x[1] = -2.0f * x[1];
    } else {
        const Lanes a = x[3] + x[1], b = x[3] - x[1], c = x[0] + x[2], d = x[0] - x[2];
        x[0] = c + c;
        x[1] = SQRT_2 * (d - a);
        x[2] = b + b;
        x[3] = -SQRT_2 * (d + a);
    }
}

// Returns the factors of a length, in the order in which they are taken; none if it has others.
inline std::vector<Index> factors_of(Index n, bool eights) {
    std::vector<Index> out;
    for (; eights && n % 8 == 0; n /= 8) out.push_back(8);
    for (; n % 4 == 0; n /= 4) out.push_back(4);
    if (n % 2 == 0) {
        n /= 2;
        out.push_back(2);
        std::swap(out.front(), out.back());
    }
    for (const Index factor : {Index(3), Index(5)})
        for (; n % factor == 0; n /= factor) out.push_back(factor);
    if (n != 1) out.clear();
    return out;
}

// A step of a transform: in each of `blocks`, `factor` transforms of `length` become one.
struct Step {
    Index factor, length, blocks;
    Index turned;                // how many numbers of a transform have roots, all but the first
    std::vector<Complex> roots;  // of each transform but the first

    Complex root(Index j, Index i) const { return roots[std::size_t((j - 1) * turned + i - 1)]; }
};

// Returns the steps of a transform of n numbers, or of the first half of n real ones' spectrum.
inline std::vector<Step> steps_of(Index n, bool real) {
    const Roots roots(n);
    std::vector<Step> steps;
    Index blocks = 1;
    for (const Index factor : factors_of(n, !real)) {
        const Index length = n / (blocks * factor);
        Step step{factor, length, blocks, real ? (length - 1) / 2 : length - 1, {}};
        for (Index j = 1; j < factor; ++j)
            for (Index i = 1; i <= step.turned; ++i) step.roots.push_back(roots[j * blocks * i]);
        steps.push_back(std::move(step));
        blocks *= factor;
    }
    return steps;
}

// Calls a function with a small factor as a constant.
template <typename Function>
void with_factor(Index factor, Function function) {
    switch (factor) {
        case 2:
            return function(std::integral_constant<Index, 2>());
        case 3:
            return function(std::integral_constant<Index, 3>());
        case 4:
            return function(std::integral_constant<Index, 4>());
        case 5:
            return function(std::integral_constant<Index, 5>());
        default:
            return function(std::integral_constant<Index, 8>());
    }
}

// The transform of complex lines, forward (turn -1) or back.
class ComplexLines {
public:
    explicit ComplexLines(Index n) : steps_(steps_of(n, false)) {
        fit(n == 1 || !steps_.empty(), "rows whose number has no prime factors but 2, 3 and 5");
    }

    // Returns where the transform of `values` is, there or in `room`.
    template <int turn>
    Numbers* run(Numbers* values, Numbers* room) const {
        for (const Step& step : steps_) {
            with_factor(step.factor,
                        [&](auto factor) { pass<factor(), turn>(step, values, room); });
            std::swap(values, room);
        }
        return values;
    }

private:
    template <Index factor, int turn>
    static void pass(const Step& step, const Numbers* from, Numbers* to) {
        const Index length = step.length, apart = length * step.blocks;
        for (Index k = 0; k < step.blocks; ++k)
            for (Index i = 0; i < length; ++i) {
                Numbers x[factor];
                for (Index j = 0; j < factor; ++j) x[j] = from[i + length * (j + factor * k)];
                butterfly<factor, turn>(x);
                Numbers* out = to + i + length * k;
                out[0] = x[0];
                for (Index j = 1; j < factor; ++j)
                    out[j * apart] = i == 0 ? x[j] : turned<turn>(x[j], step.root(j, i));
            }
    }

    std::vector<Step> steps_;
};

// The transform of real lines, and back. A spectrum lies as r0, r1, i1, r2, … in its line.
class RealLines {
public:
    explicit RealLines(Index n) : n_(n), steps_(steps_of(n, true)) {
        if (!steps_.empty()) return;
        const Roots roots(n);
        for (Index k = 0; k < n; ++k) roots_.push_back(roots[k]);
    }

    // Both return where the result is, in `values` or in `room`.
    Lanes* forward(Lanes* values, Lanes* room) const {
        if (steps_.empty()) return sums(values, room);
        for (auto step = steps_.rbegin(); step != steps_.rend(); ++step) {
            with_factor(step->factor, [&](auto factor) {
                if constexpr (factor() < 8) pass<factor()>(*step, values, room);
            });
            std::swap(values, room);
        }
        return values;
    }
    Lanes* back(Lanes* values, Lanes* room) const {
        if (steps_.empty()) return sums_back(values, room);
        for (const Step& step : steps_) {
            with_factor(step.factor, [&](auto factor) {
                if constexpr (factor() < 8) pass_back<factor()>(step, values, room);
            });
            std::swap(values, room);
        }
        return values;
    }

private:
    template <Index factor>
    static void pass(const Step& step, const Lanes* from, Lanes* to) {
        const Index length = step.length, apart = length * step.blocks;
        for (Index k = 0; k < step.blocks; ++k) {
            const Lanes* in = from + length * k;
            Lanes* out = to + length * factor * k;
            Lanes x[factor];
            for (Index j = 0; j < factor; ++j) x[j] = in[j * apart];
            halve<factor>(x);
            for (Index j = 0; j < factor; ++j)
                out[j * length + (j % 2 == 0 ? 0 : length - 1)] = x[j];
            if constexpr (factor % 2 == 0)
                if (length % 2 == 0) {
                    for (Index j = 0; j < factor; ++j) x[j] = in[j * apart + length - 1];
                    halve_between<factor>(x);
                    for (Index j = 0; j < factor; ++j)
                        out[j * length + (j % 2 == 0 ? length - 1 : 0)] = x[j];
                }
            for (Index i = 2; i < length; i += 2) {
                Numbers z[factor];
                for (Index j = 0; j < factor; ++j) {
                    const Numbers seen{in[j * apart + i - 1], in[j * apart + i]};
                    z[j] = j == 0 ? seen : turned<-1>(seen, step.root(j, i / 2));
                }
                butterfly<factor, -1>(z);
                for (Index j = 0; 2 * j < factor; ++j) {
                    out[2 * j * length + i - 1] = z[j].r;
                    out[2 * j * length + i] = z[j].i;
                }
                for (Index j = 1; 2 * j <= factor; ++j) {
                    out[2 * j * length - i - 1] = z[factor - j].r;
                    out[2 * j * length - i] = -z[factor - j].i;
                }
            }
        }
    }

    template <Index factor>
    static void pass_back(const Step& step, const Lanes* from, Lanes* to) {
        const Index length = step.length, apart = length * step.blocks;
        for (Index k = 0; k < step.blocks; ++k) {
            const Lanes* in = from + length * factor * k;
            Lanes* out = to + length * k;
            Lanes x[factor];
            for (Index j = 0; j < factor; ++j)
                x[j] = in[j * length + (j % 2 == 0 ? 0 : length - 1)];
            whole<factor>(x);
            for (Index j = 0; j < factor; ++j) out[j * apart] = x[j];
            if constexpr (factor % 2 == 0)
                if (length % 2 == 0) {
                    for (Index j = 0; j < factor; ++j)
                        x[j] = in[j * length + (j % 2 == 0 ? length - 1 : 0)];
                    whole_between<factor>(x);
                    for (Index j = 0; j < factor; ++j) out[j * apart + length - 1] = x[j];
                }
            for (Index i = 2; i < length; i += 2) {
                Numbers z[factor];
                for (Index j = 0; 2 * j < factor; ++j)
                    z[j] = {in[2 * j * length + i - 1], in[2 * j * length + i]};
                for (Index j = 1; 2 * j <= factor; ++j)
                    z[factor - j] = {in[2 * j * length - i - 1], -in[2 * j * length - i]};
                butterfly<factor, 1>(z);
                for (Index j = 0; j < factor; ++j) {
                    const Numbers made = j == 0 ? z[j] : turned<1>(z[j], step.root(j, i / 2));
                    out[j * apart + i - 1] = made.r;
                    out[j * apart + i] = made.i;
                }
            }
        }
    }

    // The transform as it is defined, for lengths with other prime factors, of x[j] + x[n - j] and
    // x[n - j] - x[j]; and the way back.
    Lanes* sums(Lanes* x, Lanes* out) const {
        for (Index j = 1; 2 * j < n_; ++j) {
            const Lanes a = x[j], b = x[n_ - j];
            x[j] = a + b;
            x[n_ - j] = b - a;
        }
        out[0] = total(x);
        for (Index k = 1; 2 * k <= n_; ++k) {
            const auto [even, odd] = sums_at(x, k);
            out[2 * k - 1] = even;
            if (2 * k < n_) out[2 * k] = odd;
        }
        return out;
    }
    Lanes* sums_back(Lanes* x, Lanes* out) const {
        Lanes* y = out + n_;  // the caller has room for both
        y[0] = x[0];
        for (Index j = 1; 2 * j < n_; ++j) {
            y[j] = 2.0f * x[2 * j - 1];
            y[n_ - j] = 2.0f * x[2 * j];
        }
        if (n_ % 2 == 0) y[n_ / 2] = x[n_ - 1];
        out[0] = total(y);
        for (Index k = 1; 2 * k <= n_; ++k) {
            const auto [even, odd] = sums_at(y, k);
            out[n_ - k] = even + odd;
            out[k] = 2 * k < n_ ? even - odd : even;
        }
        return out;
    }
    Lanes total(const Lanes* x) const {
        Lanes out = x[0];
        for (Index j = 1; 2 * j <= n_; ++j) out = out + x[j];
        return out;
    }
    // Returns the sums of cosines and of sines; after two terms, as many as there are of four, two
    // and one are added together.
    std::pair<Lanes, Lanes> sums_at(const Lanes* x, Index k) const {
        const Index pairs = (n_ - 1) / 2;
        const auto term = [&](Index j) {
            const Complex root = roots_[std::size_t(j * k % n_)];
            return std::pair{root.real() * x[j], root.imag() * x[n_ - j]};
        };
        auto [even, odd] = term(1);
        even = x[0] + even;
        for (Index j = 2, size = 1; j <= pairs; j += size) {
            if (j > 2) size = pairs - j >= 3 ? 4 : pairs - j >= 1 ? 2 : 1;
            auto [a, b] = term(j);
            for (Index i = 1; i < size; ++i) {
                const auto [c, d] = term(j + i);
                a = a + c;
                b = b + d;
            }
            even = even + a;
            odd = odd + b;
        }
        if (n_ % 2 == 0) even = even + roots_[std::size_t(n_ / 2 * k % n_)].real() * x[n_ / 2];
        return {even, odd};
    }

    Index n_;
    std::vector<Step> steps_;
    std::vector<Complex> roots_;
};

}  // namespace motes::fourier
