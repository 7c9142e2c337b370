// Ridge regression's two steps on spectra: what a filter answers, and how it learns.
#pragma once

#include <algorithm>

#include "arrays.hpp"
#include "fourier.hpp"

namespace motes::fourier_ridge {

inline void fit_filter(Plane<const Complex> spectra, Index answers, Index rows, Index columns,
                       Index power) {
    fit(rows == spectra.rows && columns == spectra.columns && answers == columns &&
            power == columns,
        "a filter (K, F) and (F,), as spectra (K, F) and a label or a response (F,)");
}

// Writes the spectrum of a filter's response, sum_k conj(numerator_k) spectra_k / power.
//
// The filter is (K, F) and (F,), the spectra of K signals (K, F), the response (F,).
inline void correlate(Plane<const Complex> numerator, Row<const float> power,
                      Plane<const Complex> spectra, Row<Complex> out) {
    fit_filter(spectra, out.size, numerator.rows, numerator.columns, power.size);
    std::fill(out.begin(), out.end(), Complex());
    for (Index k = 0; k < numerator.rows; ++k) {
        const Complex *learned = numerator[k], *seen = spectra[k];
        for (Index i = 0; i < out.size; ++i) {
            const float a = learned[i].real(), b = learned[i].imag();
            const float c = seen[i].real(), d = seen[i].imag();
            out[i] += Complex(a * c + b * d, a * d - b * c);
        }
    }
    for (Index i = 0; i < out.size; ++i) out[i] /= power[i];
}

// Writes the response's spectrum for an inverse transform with more values, padded with zeros: a
// share of the first filter's response in the learned one's, (h, w / 2 + 1) both.
//
// `gain` is the number of values for one; `out` has more rows and columns.
inline void pad(Plane<const Complex> learned, Plane<const Complex> first, double share, double gain,
                Plane<Complex> out) {
    const Index rows = learned.rows, columns = learned.columns, below = rows / 2;
    fit(first.rows == rows && first.columns == columns && out.rows >= rows &&
            out.columns >= columns,
        "two responses of one size, and room for more");
    const float other = float(1.0 - share), part = float(share), factor = float(gain);
    std::fill_n(out.data, out.rows * out.columns, Complex());
    for (Index i = 0; i < rows; ++i) {
        Complex* to = out[i < rows - below ? i : out.rows - rows + i];
        for (Index j = 0; j < columns; ++j)
            to[j] = factor * (other * learned[i][j] + part * first[i][j]);
    }
}

// Writes a plane with the value of row 0 and column 0 in the middle.
inline void center(Plane<const float> plane, Plane<float> out) {
    const Index rows = plane.rows, columns = plane.columns, half = columns / 2;
    fit(out.rows == rows && out.columns == columns, "two planes of one size");
    for (Index i = 0; i < rows; ++i) {
        float* to = out[(i + rows / 2) % rows];
        std::copy_n(plane[i], columns - half, to + half);
        std::copy_n(plane[i] + columns - half, half, to);
    }
}

// Puts a share `rate` of a lesson, spectra (K, F) and label (F,), into a filter (K, F) and (F,):
// numerator_k gets label spectra_k, power gets sum_k |spectra_k|².
inline void teach(Plane<const Complex> spectra, Row<const Complex> label, double rate,
                  Plane<Complex> numerator, Row<float> power) {
    fit_filter(spectra, label.size, numerator.rows, numerator.columns, power.size);
    const float fresh = float(rate), kept = float(1.0 - rate);
    for (float& value : power) value *= kept;
    for (Index k = 0; k < numerator.rows; ++k) {
        const Complex* seen = spectra[k];
        Complex* learned = numerator[k];
        for (Index i = 0; i < power.size; ++i) {
            const float a = fresh * label[i].real(), b = fresh * label[i].imag();
            const float c = seen[i].real(), d = seen[i].imag();
            learned[i] = kept * learned[i] + Complex(a * c - b * d, a * d + b * c);
            power[i] += fresh * (c * c + d * d);
        }
    }
}

// The sums over all planes that a filter needs at each frequency, of spectra x and of what pulls
// the filter, a = penalty copied - multiplier + inertia before; see `solve`.
class Sums {
public:
    Sums(Index size, double penalty, double inertia)
        : near_(float(penalty)),
          kept_(float(inertia)),
          both_(float(penalty + inertia)),
          size_(size),
          power_(size),
          share_(size),
          turned_(size) {
        std::fill_n(power_.begin(), size, 0.0f);
        std::fill_n(share_.begin(), size, 0.0f);
        std::fill_n(turned_.begin(), size, 0.0f);
    }

    // Adds a plane x, and writes its a, of `before` f, `copied` h and `multiplier` l.
    void add(const Complex* x, const Complex* f, const Complex* h, const Complex* l, Complex* to) {
        const float near = near_, kept = kept_;
        float* __restrict p = power_, * __restrict u = share_, * __restrict v = turned_;
        for (Index i = 0; i < size_; ++i) {
            const float a = near * h[i].real() - l[i].real() + kept * f[i].real();
            const float b = near * h[i].imag() - l[i].imag() + kept * f[i].imag();
            const float c = x[i].real(), d = x[i].imag();
            p[i] += c * c + d * d;
            u[i] += c * a + d * b;
            v[i] += c * b - d * a;
            to[i] = Complex(a, b);
        }
    }

    // Makes the filter of what `add` has written.
    void answer(Volume<const Complex> spectra, Plane<const Complex> label, Volume<Complex> out) {
        const float both = both_, scaled = both * float(label.rows * label.rows);
        float* __restrict u = share_, * __restrict v = turned_;
        for (Index i = 0; i < size_; ++i) {
            const float all = power_[i] + scaled;
            u[i] = (both * label.data[i].real() - u[i]) / all;
            v[i] = (both * label.data[i].imag() - v[i]) / all;
        }
        const float inverse = 1.0f / both;
        for (Index k = 0; k < spectra.planes; ++k) {
            const Complex* x = spectra[k].data;
            Complex* to = out[k].data;
            for (Index i = 0; i < size_; ++i) {
                const float c = x[i].real(), d = x[i].imag();
                to[i] = Complex((to[i].real() + c * u[i] - d * v[i]) * inverse,
                                (to[i].imag() + c * v[i] + d * u[i]) * inverse);
            }
        }
    }

private:
    float near_, kept_, both_;
    Index size_;
    Scratch<float> power_, share_, turned_;  // |x|², and the two parts of x^H a
};

// Writes the filter (K, F) that answers spectra (K, F) with a label (F,) and stays near to two
// others.
//
// It minimizes, at each frequency of a square window, |sum_k conj(filter_k) spectra_k -
// conj(label)|² / n²
// + penalty |filter - copied + multiplier / penalty|² + inertia |filter - before|², by the formula
// of Sherman and Morrison.
inline void solve(Volume<const Complex> spectra, Plane<const Complex> label,
                  Volume<const Complex> before, Volume<const Complex> copied,
                  Volume<const Complex> multiplier, double penalty, double inertia,
                  Volume<Complex> out) {
    Sums sums(label.rows * label.columns, penalty, inertia);
    for (Index k = 0; k < spectra.planes; ++k)
        sums.add(spectra[k].data, before[k].data, copied[k].data, multiplier[k].data, out[k].data);
    sums.answer(spectra, label, out);
}

// A box in the middle of a square window of n x n, to which planes of a filter are confined.
class Confinement {
public:
    Confinement(Index n, Index wide, Index high)
        : n_(n),
          wide_(std::min(wide, n)),
          high_(std::min(high, n)),
          transform_(n, n),
          box_(high_, n) {
        fit(wide > 0 && high > 0, "a box");
    }

    // As `confine`, of one plane. Only the lines of the box need a transform.
    void confine(Plane<const Complex> learned, double penalty, Plane<Complex> multiplier,
                 Plane<Complex> copied) const {
        const Index half = n_ / 2 + 1, top = (n_ - high_) / 2, left = (n_ - wide_) / 2;
        const float near = float(penalty), inverse = 1.0f / near;
        const Plane<Complex> lines = transform_.between(), inside{lines[top], high_, half};
        const Row<const Complex> from = learned.flat();
        const Row<Complex> part = multiplier.flat(), to = copied.flat();
        for (Index i = 0; i < from.size; ++i) to[i] = near * from[i] + part[i];
        transform_.columns_back({to.data, n_, half});
        transform_.lines_back(top, box_);
        for (Index i = 0; i < high_; ++i) {
            std::fill_n(box_[i], left, 0.0f);
            std::fill(box_[i] + left + wide_, box_[i] + n_, 0.0f);
        }
        std::fill(lines.data, inside.data, Complex());
        std::fill(inside[high_], lines[n_], Complex());
        transform_.lines_forward({box_.begin(), high_, n_}, inside);
        transform_.columns_forward(copied);
        for (Index i = 0; i < from.size; ++i) {
            to[i] *= inverse;
            part[i] += near * (from[i] - to[i]);
        }
    }

private:
    Index n_, wide_, high_;
    fourier::Planes transform_;
    ScratchPlane<float> box_;
};

// Writes the filter (K, F) that is confined to a box in the middle of its square window, and takes
// its difference from the learned one into the multiplier.
//
// The confined filter is learned + multiplier / penalty, and 0 outside of the box.
inline void confine(Volume<const Complex> learned, double penalty, Index wide, Index high,
                    Volume<Complex> multiplier, Volume<Complex> copied) {
    const Index n = learned.rows, half = learned.columns;
    for (const Volume<Complex>& other : {multiplier, copied})
        fit(other.planes == learned.planes && other.rows == n && other.columns == half,
            "three filters of one shape");
    fit(half == n / 2 + 1, "spectra (K, n, n / 2 + 1)");
    const Confinement box(n, wide, high);
    for (Index k = 0; k < learned.planes; ++k)
        box.confine(learned[k], penalty, multiplier[k], copied[k]);
}

// Writes the filter (K, F) that answers spectra with a label, is near to the one before, and 0
// outside of a box: by turns, `solve` and `confine`, with `penalties` in the first round and later.
//
// A plane is confined right before the next round adds it: a copy of it is never in memory with all
// others, and of the multipliers only where a later round needs them.
inline void alternate(Volume<const Complex> spectra, Plane<const Complex> label,
                      Volume<const Complex> before, double inertia, Pair penalties, Index rounds,
                      Index wide, Index high, Volume<Complex> out) {
    const Index planes = spectra.planes, rows = spectra.rows, columns = spectra.columns;
    fit(before.planes == planes && out.planes == planes && before.rows == rows &&
            out.rows == rows && label.rows == rows && before.columns == columns &&
            out.columns == columns && label.columns == columns && columns == rows / 2 + 1 &&
            rounds > 0,
        "spectra (K, n, n / 2 + 1) and filters of one shape, their label, and a round");
    const Index size = rows * columns;
    const Confinement box(rows, wide, high);
    ScratchPlane<Complex> copied(rows, columns), multipliers(rounds > 2 ? planes : 1, size);
    std::fill_n(copied.begin(), size, Complex());
    std::fill_n(multipliers.begin(), multipliers.rows() * size, Complex());
    for (Index round = 0; round < rounds; ++round) {
        const double last = round == 1 ? penalties.x : penalties.y;
        Sums sums(size, round == 0 ? penalties.x : penalties.y, inertia);
        for (Index k = 0; k < planes; ++k) {
            const Plane<Complex> multiplier{multipliers[rounds > 2 ? k : 0], rows, columns};
            if (rounds == 2) std::fill_n(multiplier.data, size, Complex());
            Complex* filter = out[k].data;
            if (round > 0) box.confine({filter, rows, columns}, last, multiplier, copied);
            sums.add(spectra[k].data, before[k].data, copied.begin(), multiplier.data, filter);
        }
        sums.answer(spectra, label, out);
    }
}

}  // namespace motes::fourier_ridge
