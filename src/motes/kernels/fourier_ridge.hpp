// Ridge regression's two steps on spectra: what a filter answers, and how it learns.
#pragma once

#include <algorithm>

#include "arrays.hpp"

namespace motes::fourier_ridge {

// Writes the spectrum of a filter's response, sum_k conj(numerator_k) spectra_k / power.
//
// The filter is (K, F) and (F,), the spectra of K signals (K, F), the response (F,).
inline void correlate(Plane<const Complex> numerator, Row<const float> power,
                      Plane<const Complex> spectra, Row<Complex> out) {
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

}  // namespace motes::fourier_ridge
