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

// Writes the filter (K, F) that answers spectra (K, F) with a label (F,) and stays near to two
// others.
//
// It minimizes, at each frequency of a square window, |sum_k conj(filter_k) spectra_k -
// conj(label)|² / n²
// + penalty |filter - copied + multiplier / penalty|² + inertia |filter - before|², by the formula
// of Sherman and Morrison.
//
// `first` is the first round, in which both `copied` and the multiplier are 0, and not read.
template <bool first = false>
void solve(Volume<const Complex> spectra, Plane<const Complex> label, Volume<const Complex> before,
           Volume<const Complex> copied, Volume<const Complex> multiplier, double penalty,
           double inertia, Volume<Complex> out) {
    const Index size = label.rows * label.columns;
    const float both = float(penalty + inertia), near = float(penalty), kept = float(inertia);
    const float scaled = both * float(label.rows * label.rows);
    Scratch<float> power(size), share(size), turned(size);  // |x|², and the two parts of x^H a
    std::fill_n(power.begin(), size, 0.0f);
    std::fill_n(share.begin(), size, 0.0f);
    std::fill_n(turned.begin(), size, 0.0f);
    float* __restrict p = power, * __restrict u = share, * __restrict v = turned;
    for (Index k = 0; k < spectra.planes; ++k) {
        const Complex *x = spectra[k].data, *f = before[k].data;
        const Complex *h = copied[k].data, *l = multiplier[k].data;
        Complex* to = out[k].data;
        for (Index i = 0; i < size; ++i) {
            float a = kept * f[i].real(), b = kept * f[i].imag();
            if constexpr (!first) {
                a = near * h[i].real() - l[i].real() + a;
                b = near * h[i].imag() - l[i].imag() + b;
            }
            const float c = x[i].real(), d = x[i].imag();
            p[i] += c * c + d * d;
            u[i] += c * a + d * b;
            v[i] += c * b - d * a;
            to[i] = Complex(a, b);
        }
    }
    for (Index i = 0; i < size; ++i) {
        const float all = p[i] + scaled;
        u[i] = (both * label.data[i].real() - u[i]) / all;
        v[i] = (both * label.data[i].imag() - v[i]) / all;
    }
    const float inverse = 1.0f / both;
    for (Index k = 0; k < spectra.planes; ++k) {
        const Complex* x = spectra[k].data;
        Complex* to = out[k].data;
        for (Index i = 0; i < size; ++i) {
            const float c = x[i].real(), d = x[i].imag();
            to[i] = Complex((to[i].real() + c * u[i] - d * v[i]) * inverse,
                            (to[i].imag() + c * v[i] + d * u[i]) * inverse);
        }
    }
}

// Writes the filter (K, F) that is confined to a box in the middle of its square window, and takes
// its difference from the learned one into the multiplier.
//
// The confined filter is learned + multiplier / penalty, and 0 outside of the box. Only the lines
// of the box need a transform. `first` as in `solve`.
template <bool first = false>
void confine(Volume<const Complex> learned, double penalty, Index wide, Index high,
             Volume<Complex> multiplier, Volume<Complex> copied) {
    const Index n = learned.rows, half = learned.columns;
    for (const Volume<Complex>& other : {multiplier, copied})
        fit(other.planes == learned.planes && other.rows == n && other.columns == half,
            "three filters of one shape");
    fit(half == n / 2 + 1 && wide > 0 && high > 0, "spectra (K, n, n / 2 + 1) and a box");
    high = std::min(high, n), wide = std::min(wide, n);
    const Index top = (n - high) / 2, left = (n - wide) / 2;
    const float near = float(penalty), inverse = 1.0f / near;
    const fourier::Planes transform(n, n);
    ScratchPlane<float> box(high, n);
    const Plane<Complex> lines = transform.between(), inside{lines[top], high, half};
    for (Index k = 0; k < learned.planes; ++k) {
        const Row<const Complex> from = learned[k].flat();
        const Row<Complex> part = multiplier[k].flat(), to = copied[k].flat();
        for (Index i = 0; i < from.size; ++i)
            to[i] = first ? near * from[i] : near * from[i] + part[i];
        transform.columns_back({to.data, n, half});
        transform.lines_back(top, box);
        for (Index i = 0; i < high; ++i) {
            std::fill_n(box[i], left, 0.0f);
            std::fill(box[i] + left + wide, box[i] + n, 0.0f);
        }
        std::fill(lines.data, inside.data, Complex());
        std::fill(inside[high], lines[n], Complex());
        transform.lines_forward({box.begin(), high, n}, inside);
        transform.columns_forward(copied[k]);
        for (Index i = 0; i < from.size; ++i) {
            to[i] *= inverse;
            const Complex off = near * (from[i] - to[i]);
            part[i] = first ? off : part[i] + off;
        }
    }
}

// Writes the filter (K, F) that answers spectra with a label, is near to the one before, and 0
// outside of a box: by turns, `solve` and `confine`, with `penalties` in the first round and later.
inline void alternate(Volume<const Complex> spectra, Plane<const Complex> label,
                      Volume<const Complex> before, double inertia, Pair penalties, Index rounds,
                      Index wide, Index high, Volume<Complex> out) {
    const Index planes = spectra.planes, rows = spectra.rows, columns = spectra.columns;
    fit(before.planes == planes && out.planes == planes && before.rows == rows &&
            out.rows == rows && label.rows == rows && before.columns == columns &&
            out.columns == columns && label.columns == columns && rounds > 0,
        "spectra and filters of one shape, their label, and a round");
    Scratch<Complex> one(planes * rows * columns), other(planes * rows * columns);
    const Volume<Complex> copied{one, planes, rows, columns}, kept{other, planes, rows, columns};
    const Volume<const Complex> copy{one, planes, rows, columns},
        held{other, planes, rows, columns};
    const Volume<const Complex> learned{out.data, planes, rows, columns};
    solve<true>(spectra, label, before, copy, held, penalties.x, inertia, out);
    if (rounds > 1) confine<true>(learned, penalties.x, wide, high, kept, copied);
    for (Index round = 2; round <= rounds; ++round) {
        solve(spectra, label, before, copy, held, penalties.y, inertia, out);
        if (round < rounds) confine(learned, penalties.y, wide, high, kept, copied);
    }
}

}  // namespace motes::fourier_ridge
