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
