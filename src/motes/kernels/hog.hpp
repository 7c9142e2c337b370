// Histograms of oriented gradients, by cells of the box around an ellipse.
#pragma once

#include "gradients.hpp"
#include "histograms.hpp"

namespace motes::hog {

constexpr Index BAND = 32;

// Writes the strength of gradients and the bins of their directions.
//
// The `count` bins are of equal width over a whole turn, the first one centered on the -x axis.
inline void directions(const float* gx, const float* gy, Index size, std::int32_t count,
                       float* __restrict strength, std::uint8_t* __restrict bins) {
    for (Index i = 0; i < size; ++i) {
        const auto number = std::int32_t(gradients::turn(gy[i], gx[i]) * float(count) + 0.5f);
        bins[i] = std::uint8_t(number < count ? number : 0);  // a whole turn is none
        strength[i] = std::sqrt(gx[i] * gx[i] + gy[i] * gy[i]);
    }
}

// Writes strength and direction of the gradient at each pixel of a region, as `directions`.
inline void gradients(Picture picture, Index left, Index top, Taps smooth, Taps derivative,
                      Plane<float> strength, Plane<std::uint8_t> bins, int count) {
    const Index width = strength.columns;
    for (Index above = 0; above < strength.rows; above += BAND) {  // which stay in a core's cache
        const Index rows = std::min(BAND, strength.rows - above);
        ScratchPlane<float> gx(rows, width), gy(rows, width);
        gradients::derivatives(picture, left, top + above, 1, smooth, derivative, gx, gy);
        for (Index i = 0; i < rows; ++i)
            directions(gx[i], gy[i], width, count, strength[above + i], bins[above + i]);
    }
}

// Cells of the box around an ellipse, `side` of them to a side; cells are numbered row by row.
//
// The box is that of the ellipse's own axes, and turns with it: cells of a lattice's points are the
// same in all ellipses.
class Cells {
public:
    Cells(Index side, const sampling::Reading& reading, Index room) : side_(side), cells_(room) {
        const Plane<const float> lattice = reading.lattice;
        for (Index i = 0; i < lattice.columns; ++i) cells_[i] = cell(lattice[0][i], lattice[1][i]);
        fixed_ = lattice.columns > 0;
    }

    // Returns the cell of each point that is read of an ellipse in a window of one channel.
    const std::uint32_t* of(sampling::Window window, const double* ellipse,
                            histograms::Points points) const {
        if (fixed_) return cells_;
        const double cos = std::cos(ellipse[4]), sin = std::sin(ellipse[4]);
        for (Index i = 0; i < points.count; ++i) {
            const auto place = points.offsets[i], width = std::uint32_t(window.width);
            const double x = double(window.left + place % width) - ellipse[0];
            const double y = double(window.top + place / width) - ellipse[1];
            cells_[i] = cell((x * cos + y * sin) / ellipse[2], (y * cos - x * sin) / ellipse[3]);
        }
        return cells_;
    }

private:
    // Returns the cell at u, v from -1 to 1 in the ellipse's own half-axes.
    std::uint32_t cell(double u, double v) const {
        const double half = 0.5 * double(side_);
        const auto column = Index((u + 1.0) * half), row = Index((v + 1.0) * half);
        return std::uint32_t(std::min(row, side_ - 1) * side_ + std::min(column, side_ - 1));
    }

    Index side_;
    Scratch<std::uint32_t> cells_;
    bool fixed_;
};

// Writes a normalized histogram of gradients by cell and direction, `count` directions to a cell.
//
// If `turned`, each cell's is turned by whole bins, all alike, so that the direction that is
// strongest over all cells comes first.
inline void by_cell(Floats filled, Index count, bool turned, double* histogram) {
    double total = 0.0, most = 0.0;
    Index first = 0;
    for (Index u = 0; u < count; ++u) {
        double direction = 0.0;
        for (Index cell = 0; cell < filled.size; cell += count) direction += filled[cell + u];
        total += direction;
        if (turned && direction > most) most = direction, first = u;
    }
    for (Index cell = 0; cell < filled.size; cell += count)
        for (Index u = 0; u < count; ++u) {
            const double value = filled[cell + (u + first) % count];
            histogram[cell + u] = total > 0.0 ? value / total : 0.0;
        }
}

// As `histograms::each` for side x side cells; `look(points, strength, bins)` finds gradients.
template <typename Look>
void each(sampling::Window window, Ellipses ellipses, const sampling::Reading& reading, Index side,
          bool turned, Look look, Histograms out) {
    fit(out.rows == ellipses.rows && side > 0 && out.columns > 0 &&
            out.columns % (side * side) == 0,
        "a histogram for each ellipse, with the same directions in each cell");
    const Index room = sampling::capacity(window, ellipses, reading);
    const auto count = std::uint32_t(out.columns / (side * side));
    Scratch<float> strength(room);
    Scratch<std::uint8_t> bins(room);
    Scratch<std::uint32_t> found(room);
    const Cells cells(side, reading, room);
    const auto keys = [&](Index n, histograms::Points points) -> const std::uint32_t* {
        look(points, strength, bins);
        const std::uint32_t* cell = cells.of(window, ellipses[n], points);
        for (Index i = 0; i < points.count; ++i) {
            found[i] = cell[i] * count + bins[i];
            points.weights[i] *= strength[i];
        }
        return found;
    };
    histograms::each(window, ellipses, reading, out.columns, histograms::Same(), keys,
                     [&](Index n, Floats filled) { by_cell(filled, count, turned, out[n]); });
}

// Writes each ellipse's histogram of gradients, as `by_cell`; zeros where there is none.
//
// The planes of strength and direction begin at left, top.
inline void histograms(Plane<const float> strength, Plane<const std::uint8_t> bins, Index left,
                       Index top, Ellipses ellipses, const sampling::Reading& reading, Index side,
                       bool turned, Histograms out) {
    const auto look = [&](histograms::Points points, float* values, std::uint8_t* numbers) {
        for (Index i = 0; i < points.count; ++i) {
            values[i] = strength.data[points.offsets[i]];
            numbers[i] = bins.data[points.offsets[i]];
        }
    };
    each(sampling::window_of(left, top, bins.columns, bins.rows), ellipses, reading, side, turned,
         look, out);
}

// Writes the same histograms without planes, by gradients at a lattice's points.
inline void histograms_at(Picture picture, Ellipses ellipses, Plane<const float> lattice,
                          int profile, Index side, bool turned, Taps smooth, Taps derivative,
                          Histograms out) {
    const Index room = lattice.columns;
    const auto count = std::int32_t(out.columns / (side * side));
    const gradients::DerivativesAt derivatives(picture, smooth, derivative, room);
    Scratch<float> gx(room), gy(room);
    const auto look = [&](histograms::Points points, float* values, std::uint8_t* numbers) {
        derivatives(points.offsets, points.count, gx, gy);
        directions(gx, gy, points.count, count, values, numbers);
    };
    each(sampling::window_of(0, 0, picture.width, picture.height), ellipses,
         {lattice, {1, 1}, profile}, side, turned, look, out);
}

}  // namespace motes::hog
