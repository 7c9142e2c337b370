// Fourier transforms of planes, of 5-smooth numbers of rows and any numbers of columns.
#pragma once

#include "fourier_lines.hpp"

namespace motes::fourier {

// Calls a function with the first of each group of lines, and with their number as a constant if it
// is that of the lanes. The last group overlaps the one before, so that all lanes are used.
template <typename Function>
void in_groups(Index lines, Function function) {
    if (lines < LANES) return function(Index(0), lines);
    for (Index first = 0; first < lines; first += LANES)
        function(std::min(first, lines - LANES), std::integral_constant<Index, LANES>());
}

// Returns what a function returns for each lane.
template <typename Count, typename Function>
Lanes gathered(Count count, Function function) {
    Lanes out{};
    for (Index lane = 0; lane < count; ++lane) out[lane] = function(lane);
    return out;
}

// Transforms of planes of one size. A spectrum (h, w / 2 + 1) may have only its first columns, the
// others being 0.
class Planes {
public:
    Planes(Index rows, Index columns) : Planes(rows, columns, columns / 2 + 1) {}
    Planes(Index rows, Index columns, Index known)
        : rows_(rows),
          columns_(columns),
          across_(columns),
          down_(rows),
          values_(2 * columns),
          room_(2 * columns),
          numbers_(rows),
          more_(rows),
          between_(rows, known) {}

    void forward(Plane<const float> plane, Plane<Complex> out) const {
        lines_forward(plane, between_);
        columns_forward(out);
    }
    void back(Plane<const Complex> spectrum, Plane<float> out) const {
        columns_back(spectrum);
        lines_back(0, out);
    }

    // Writes the spectra of lines.
    void lines_forward(Plane<const float> lines, Plane<Complex> out) const {
        in_groups(lines.rows, [&](Index first, auto count) {
            const float* line = lines[first];
            for (Index j = 0; j < columns_; ++j)
                values_[j] = gathered(count, [&](Index i) { return line[i * columns_ + j]; });
            const Lanes* found = across_.forward(values_, room_);
            for (Index lane = 0; lane < count; ++lane) {
                Complex* to = out[first + lane];
                to[0] = found[0][lane];
                for (Index j = 1; 2 * j < columns_; ++j)
                    to[j] = {found[2 * j - 1][lane], found[2 * j][lane]};
                if (columns_ % 2 == 0) to[columns_ / 2] = found[columns_ - 1][lane];
            }
        });
    }
    // Writes lines from `top` on of what `columns_back` has left.
    void lines_back(Index top, Plane<float> out) const {
        const float share = float(1.0 / double(rows_ * columns_));
        in_groups(out.rows, [&](Index first, auto count) {
            const Complex* line = between_[top + first];
            const Index known = between_.columns();
            values_[0] = gathered(count, [&](Index i) { return line[i * known].real(); });
            for (Index j = 1; j < columns_; ++j) {
                const Index column = (j + 1) / 2;
                if (column >= known)
                    values_[j] = Lanes{};
                else if (j % 2 == 1)
                    values_[j] =
                        gathered(count, [&](Index i) { return line[i * known + column].real(); });
                else
                    values_[j] =
                        gathered(count, [&](Index i) { return line[i * known + column].imag(); });
            }
            const Lanes* found = across_.back(values_, room_);
            for (Index lane = 0; lane < count; ++lane)
                for (Index j = 0; j < columns_; ++j) out[first + lane][j] = share * found[j][lane];
        });
    }
    void columns_forward(Plane<Complex> out) const {
        turn<-1>({between_.begin(), rows_, between_.columns()}, out);
    }
    void columns_back(Plane<const Complex> spectrum) const { turn<1>(spectrum, between_); }
    Plane<Complex> between() const { return between_; }

private:
    template <int way>
    void turn(Plane<const Complex> from, Plane<Complex> to) const {
        in_groups(from.columns, [&](Index first, auto count) {
            for (Index i = 0; i < rows_; ++i) {
                const Complex* line = from[i] + first;
                numbers_[i] = {gathered(count, [&](Index lane) { return line[lane].real(); }),
                               gathered(count, [&](Index lane) { return line[lane].imag(); })};
            }
            const Numbers* found = down_.run<way>(numbers_, more_);
            for (Index i = 0; i < rows_; ++i)
                for (Index lane = 0; lane < count; ++lane)
                    to[i][first + lane] = {found[i].r[lane], found[i].i[lane]};
        });
    }

    Index rows_, columns_;
    RealLines across_;
    ComplexLines down_;
    Scratch<Lanes> values_, room_;
    Scratch<Numbers> numbers_, more_;
    ScratchPlane<Complex> between_;  // a plane of which only the lines are transformed
};

// Writes the transforms (K, h, w / 2 + 1) of planes (K, h, w).
inline void rfft2(Volume<const float> planes, Volume<Complex> out) {
    fit(out.planes == planes.planes && out.rows == planes.rows &&
            out.columns == planes.columns / 2 + 1 && planes.rows > 0 && planes.columns > 0,
        "spectra (K, h, w / 2 + 1) for planes (K, h, w)");
    const Planes transform(planes.rows, planes.columns);
    for (Index k = 0; k < planes.planes; ++k) transform.forward(planes[k], out[k]);
}

// Writes planes (K, h, w) from their transforms (K, h, up to w / 2 + 1).
inline void irfft2(Volume<const Complex> spectra, Volume<float> out) {
    fit(out.planes == spectra.planes && out.rows == spectra.rows && spectra.columns > 0 &&
            spectra.columns <= out.columns / 2 + 1 && out.rows > 0 && out.columns > 0,
        "spectra (K, h, up to w / 2 + 1) for planes (K, h, w)");
    const Planes transform(out.rows, out.columns, spectra.columns);
    for (Index k = 0; k < out.planes; ++k) transform.back(spectra[k], out[k]);
}

// Writes the transforms (N, n / 2 + 1) of lines (N, n).
inline void rfft(Plane<const float> lines, Plane<Complex> out) {
    fit(out.rows == lines.rows && out.columns == lines.columns / 2 + 1 && lines.columns > 0,
        "spectra (N, n / 2 + 1) for lines (N, n)");
    Planes(1, lines.columns).lines_forward(lines, out);
}

}  // namespace motes::fourier
