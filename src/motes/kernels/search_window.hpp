// A window of fixed samples cut from a picture, and its cells of gradients.
#pragma once

#include <algorithm>

#include "arrays.hpp"

namespace motes::search_window {

constexpr Index CELL = 4;  // samples to a side of a cell

// Does as `cut` does with samples between pixels.
inline void cut_between(Picture picture, Pair corner, Pair across, Pair down, Volume<float> out) {
    const float right = float(picture.width - 1), low = float(picture.height - 1);
    const float across_x = float(across.x), across_y = float(across.y);
    const Index width = out.columns, red = picture.red(), green = picture.green();
    const Index blue = picture.blue();
    // Loops over arrays, so that all but the reading of pixels becomes vector code.
    Scratch<std::int32_t> columns(width), rows(width);
    ScratchPlane<float> shares(4, width);
    ScratchPlane<std::uint32_t> around(4, width);  // the four pixels, a byte for each channel
    for (Index i = 0; i < out.rows; ++i) {
        const float left = float(corner.x + double(i) * down.x);
        const float top = float(corner.y + double(i) * down.y);
        std::int32_t* __restrict column = columns, * __restrict row = rows;
        float* __restrict share0 = shares[0], * __restrict share1 = shares[1];
        float* __restrict share2 = shares[2], * __restrict share3 = shares[3];
        for (std::int32_t j = 0; j < std::int32_t(width); ++j) {
            const float x = limited(left + float(j) * across_x, right);
            const float y = limited(top + float(j) * across_y, low);
            column[j] = std::int32_t(x), row[j] = std::int32_t(y);
            const float u = x - float(column[j]), v = y - float(row[j]);
            share3[j] = u * v, share1[j] = u - share3[j], share2[j] = v - share3[j];
            share0[j] = 1.0f - u - share2[j];
        }
        for (Index j = 0; j < width; ++j) {
            const std::uint8_t* here = picture.row(row[j]) + picture.pixel * column[j];
            const Index beside = column[j] < picture.width - 1 ? picture.pixel : 0;
            const Index below = row[j] < picture.height - 1 ? picture.line : 0;
            const auto read = [&](const std::uint8_t* pixel) {
                return std::uint32_t(pixel[red] | pixel[green] << 8 | pixel[blue] << 16);
            };
            around[0][j] = read(here), around[1][j] = read(here + beside);
            around[2][j] = read(here + below), around[3][j] = read(here + below + beside);
        }
        for (Index c = 0; c < 3; ++c) {
            float* __restrict to = out[c][i];
            const std::uint32_t *first = around[0], *second = around[1], *third = around[2];
            const std::uint32_t* fourth = around[3];
            const auto value = [c](std::uint32_t pixel) {
                return float(std::int32_t(pixel >> (8 * c) & 255));
            };
            for (Index j = 0; j < width; ++j)
                to[j] = share0[j] * value(first[j]) + share1[j] * value(second[j]) +
                        share2[j] * value(third[j]) + share3[j] * value(fourth[j]);
        }
    }
}

// Adds up `count` pixels for each sample of a row, at `columns`, in bytes, and `rows` (count, W).
inline void add_pixels(Picture picture, Index count, const std::int32_t* columns,
                       const std::int32_t* rows, Plane<std::int32_t> sums) {
    for (Index j = 0; j < sums.columns; ++j) {
        std::int32_t red = 0, green = 0, blue = 0;
        for (Index k = j; k < count * sums.columns; k += sums.columns) {
            const std::uint8_t* pixel = picture.row(rows[k]) + columns[k];
            red += pixel[picture.red()], green += pixel[picture.green()];
            blue += pixel[picture.blue()];
        }
        sums[0][j] = red, sums[1][j] = green, sums[2][j] = blue;
    }
}

// Does as `cut` does with samples along any two directions.
inline void cut_turned(Picture picture, Pair corner, Pair across, Pair down, Volume<float> out) {
    const double step_x = std::hypot(across.x, across.y), step_y = std::hypot(down.x, down.y);
    if (step_x < 1.0 || step_y < 1.0) return cut_between(picture, corner, across, down, out);
    const auto beside = Index(std::min(4.0, step_x + 0.5));
    const auto below = Index(std::min(4.0, step_y + 0.5));
    const auto share = float(1.0 / double(beside * below));
    const auto right = double(picture.width - 1), low = double(picture.height - 1);
    const auto bytes = std::int32_t(picture.pixel);
    // Loops over arrays, so that all but the reading of pixels becomes vector code. All samples of
    // a row have a first pixel, then all a second one.
    const Index line = beside * out.columns;
    Scratch<double> off_x(line), off_y(line);  // of a row's pixels from where the row begins
    for (Index v = 0; v < beside; ++v) {
        for (Index j = 0; j < out.columns; ++j) {
            const double x = double(j) - 0.5 + (double(v) + 0.5) / double(beside);
            off_x.begin()[v * out.columns + j] = x * across.x;
            off_y.begin()[v * out.columns + j] = x * across.y;
        }
    }
    ScratchPlane<std::int32_t> columns(below, line), rows(below, line), sums(3, out.columns);
    for (Index i = 0; i < out.rows; ++i) {
        for (Index u = 0; u < below; ++u) {
            const double y = double(i) - 0.5 + (double(u) + 0.5) / double(below);
            const double left = corner.x + y * down.x + 0.5, top = corner.y + y * down.y + 0.5;
            std::int32_t* __restrict column = columns[u], * __restrict row = rows[u];
            const double *x = off_x, *y_off = off_y;
            for (Index k = 0; k < line; ++k)
                column[k] = bytes * std::int32_t(limited(left + x[k], right));
            for (Index k = 0; k < line; ++k) row[k] = std::int32_t(limited(top + y_off[k], low));
        }
        add_pixels(picture, beside * below, columns[0], rows[0], sums);
        for (Index c = 0; c < 3; ++c) {
            float* __restrict to = out[c][i];
            const std::int32_t* sum = sums[c];
            for (Index j = 0; j < out.columns; ++j) to[j] = float(sum[j]) * share;
        }
    }
}

// Which pixels of a line count how much for each of its samples: `taps` of them for one.
class Line {
public:
    // `count` samples from `start`, `step` pixels apart, of `limit` pixels of `bytes` each.
    Line(double start, double step, Index count, Index limit, Index bytes)
        : taps(step < 1.0 ? 2 : Index(std::min(4.0, step + 0.5))),
          places(count, taps),
          shares(count, taps) {
        for (Index i = 0; i < count; ++i) {
            if (step < 1.0) {
                const double x = limited(start + double(i) * step, double(limit - 1));
                const auto place = Index(x);
                places[i][0] = place * bytes;
                places[i][1] = std::min(place + 1, limit - 1) * bytes;
                shares[i][0] = float(1.0 - (x - double(place)));
                shares[i][1] = float(x - double(place));
                continue;
            }
            for (Index u = 0; u < taps; ++u) {
                const double off = double(i) - 0.5 + (double(u) + 0.5) / double(taps);
                places[i][u] = Index(limited(start + off * step + 0.5, double(limit - 1))) * bytes;
                shares[i][u] = float(1.0 / double(taps));
            }
        }
        const Index size = count * taps;
        first = *std::min_element(places.begin(), places.begin() + size);
        for (Index i = 0; i < size; ++i) places.begin()[i] -= first;
        last = *std::max_element(places.begin(), places.begin() + size);
    }

    const Index taps;
    Index first, last;           // in bytes: the first pixel that counts, and the last from there
    ScratchPlane<Index> places;  // in bytes from there
    ScratchPlane<float> shares;
};

// Writes the weighted sum of the `taps` lines of a picture that count for row `i` of the samples.
template <Index taps>
void join(const Line& rows, const std::uint8_t* start, Index i, Index span,
          float* __restrict line) {
    const std::uint8_t* sources[taps];
    float shares[taps];
    for (Index u = 0; u < taps; ++u)
        sources[u] = start + rows.places[i][u], shares[u] = rows.shares[i][u];
    for (Index c = 0; c < span; ++c) {
        float sum = 0.0f;
        for (Index u = 0; u < taps; ++u) sum += shares[u] * float(sources[u][c]);
        line[c] = sum;
    }
}

// Writes a row of samples (3, W), row `i` of `out`, each from `taps` pixels of a picture's line.
//
// A pixel's channels are `apart` places apart: 0 if it is gray. Four are added up at once, in
// `sums` (4 W,), as vector code; the fourth is what lies behind a pixel, and is left there.
template <Index taps, Index apart>
void weigh(const Line& columns, const float* line, bool reversed, Index i, float* __restrict sums,
           Volume<float> out) {
    for (Index j = 0; j < out.columns; ++j) {
        float sum[4] = {};
        for (Index v = 0; v < taps; ++v) {
            const float share = columns.shares[j][v];
            const float* pixel = line + columns.places[j][v];
            for (Index c = 0; c < 4; ++c) sum[c] += share * pixel[c * apart];
        }
        std::copy_n(sum, 4, sums + 4 * j);
    }
    float* __restrict first = out[reversed ? 2 : 0][i], * __restrict middle = out[1][i];
    float* __restrict last = out[reversed ? 0 : 2][i];
    for (Index j = 0; j < out.columns; ++j) {
        const float* sum = sums + 4 * j;
        first[j] = sum[0], middle[j] = sum[1], last[j] = sum[2];
    }
}

// Does as `cut` does with samples along the picture's rows and columns, `step` pixels apart.
inline void cut_upright(Picture picture, Pair corner, Pair step, Volume<float> out) {
    const Line columns(corner.x, step.x, out.columns, picture.width, picture.pixel);
    const Line rows(corner.y, step.y, out.rows, picture.height, picture.line);
    const Index span = columns.last + picture.span(1);
    const std::uint8_t* start = picture.data + rows.first + columns.first;
    Scratch<float> scratch(span + 1), sums(4 * out.columns);
    float* __restrict line = scratch;
    line[span] = 0.0f;  // behind the last pixel
    constexpr decltype(&weigh<1, 0>) by_taps[2][4] = {
        {weigh<1, 0>, weigh<2, 0>, weigh<3, 0>, weigh<4, 0>},
        {weigh<1, 1>, weigh<2, 1>, weigh<3, 1>, weigh<4, 1>}};
    const auto weigh_row = by_taps[picture.order != Order::GRAY][columns.taps - 1];
    constexpr decltype(&join<1>) joins[4] = {join<1>, join<2>, join<3>, join<4>};
    const auto join_lines = joins[rows.taps - 1];
    for (Index i = 0; i < out.rows; ++i) {
        join_lines(rows, start, i, span, line);
        weigh_row(columns, line, picture.order == Order::BGR, i, sums, out);
    }
}

// Writes the samples (3, H, W) of a part of a picture: red, green and blue, 0 to 255.
//
// The sample in row i and column j lies at corner + j across + i down, each in x and y. Where it
// stands for several pixels, it is the mean of up to 4x4 of them; between pixels it is bilinear.
// Outside the picture its border goes on.
inline void cut(Picture picture, Pair corner, Pair across, Pair down, Volume<float> out) {
    fit(picture.height > 0 && picture.width > 0 && out.planes == 3 && out.rows > 0 &&
            out.columns > 0,
        "a picture, and room for three colors");
    if (across.y == 0.0 && down.x == 0.0)
        cut_upright(picture, corner, {across.x, down.y}, out);
    else
        cut_turned(picture, corner, across, down, out);
}

// A target's place, and the direction of its sides.
struct Place {
    double x, y, a, b, theta;
};

// Does as `cut` does around a place, in its directions, with samples `step` pixels apart.
inline void cut_around(Picture picture, const Place& place, Pair step, Volume<float> out) {
    const double cos = std::cos(place.theta), sin = std::sin(place.theta);
    const Pair across{step.x * cos, step.x * sin}, down{-step.y * sin, step.y * cos};
    const double right = double(out.columns - 1) / 2, low = double(out.rows - 1) / 2;
    const Pair corner{place.x - right * across.x - low * down.x,
                      place.y - right * across.y - low * down.y};
    cut(picture, corner, across, down, out);
}

// Writes R + G + B of samples (H + 2, W + 2), those at the border twice.
inline void brightness(Samples samples, Plane<float> out) {
    const Index height = samples.rows, width = samples.columns;
    for (Index i = 0; i < height + 2; ++i) {
        const Index row = std::min(std::max(i - 1, Index(0)), height - 1);
        const float *red = samples[0][row], *green = samples[1][row], *blue = samples[2][row];
        float* __restrict line = out[i];
        for (Index j = 0; j < width; ++j) line[j + 1] = red[j] + green[j] + blue[j];
        line[0] = line[1], line[width + 1] = line[width];
    }
}

// Writes the votes of samples' gradients, each for the four cells around, (h + 2, 18 (w + 2)): of
// each row of cells all of one sector, then all of the next.
inline void vote(Samples samples, Plane<const std::uint8_t> sectors, Plane<float> votes) {
    const Index height = samples.rows, width = samples.columns;
    const auto cells = std::int32_t(votes.columns / 18);
    ScratchPlane<float> bright(height + 2, width + 2), near(CELL, width), far(CELL, width);
    ScratchPlane<float> lines(CELL, votes.columns);
    ScratchPlane<std::int32_t> gradients(CELL, width);
    Scratch<std::int32_t> left(width);
    Scratch<float> across(width);
    for (Index j = 0; j < width; ++j) {
        const double x = (double(j) + 0.5) / double(CELL) + 0.5;
        left[j] = std::int32_t(x), across[j] = float(x - double(Index(x)));
    }
    std::fill_n(votes.data, votes.rows * votes.columns, 0.0f);
    brightness(samples, bright);
    for (Index top = 0; top < height; top += CELL) {
        for (Index u = 0; u < CELL; ++u) {
            const float *before = bright[top + u], *here = bright[top + u + 1];
            const float *after = bright[top + u + 2], *share = across;
            float* __restrict one = near[u], * __restrict other = far[u];
            std::int32_t* __restrict gradient = gradients[u];
            for (Index j = 0; j < width; ++j) {
                const float dx = here[j + 2] - here[j], dy = after[j + 1] - before[j + 1];
                const float magnitude = std::sqrt(dx * dx + dy * dy);
                other[j] = magnitude * share[j], one[j] = magnitude - other[j];
                const auto row = std::int32_t(limited(dy * float(1.0 / 3) + 256.5f, 511.0f));
                const auto column = std::int32_t(limited(dx * float(1.0 / 3) + 256.5f, 511.0f));
                gradient[j] = 512 * row + column;
            }
        }
        // Rows side by side, as a vote must wait for the one before it for the same cell.
        std::fill_n(lines.begin(), CELL * votes.columns, 0.0f);
        for (Index j = 0; j < width; ++j)
            for (Index u = 0; u < CELL; ++u) {
                float* to = lines[u] + cells * sectors.data[gradients[u][j]] + left[j];
                to[0] += near[u][j], to[1] += far[u][j];
            }
        for (Index u = 0; u < CELL; ++u) {
            const double y = (double(top + u) + 0.5) / double(CELL) + 0.5;
            const auto low = double(float(y - double(Index(y))));
            const float* line = lines[u];
            float* __restrict upper = votes[Index(y)];
            float* __restrict lower = votes[Index(y) + 1];
            for (Index k = 0; k < votes.columns; ++k) {
                upper[k] = float(double(upper[k]) + (1 - low) * double(line[k]));
                lower[k] += float(low) * line[k];
            }
        }
    }
}

// Writes the energy (h + 2, w + 2) of cells: squared votes of 9 orientations; those at the border
// are repeated.
inline void energies(Plane<const float> votes, Plane<float> energy) {
    const Index rows = energy.rows - 2, columns = energy.columns - 2, cells = energy.columns;
    std::fill_n(energy.data, energy.rows * energy.columns, 0.0f);
    for (Index i = 1; i <= rows; ++i) {
        float* __restrict line = energy[i];
        for (Index k = 0; k < 9; ++k) {
            const float *one = votes[i] + k * cells, *opposite = one + 9 * cells;
            for (Index j = 1; j <= columns; ++j) {
                const float both = one[j] + opposite[j];
                line[j] += both * both;
            }
        }
    }
    for (Index j = 1; j <= columns; ++j)
        energy[0][j] = energy[1][j], energy[rows + 1][j] = energy[rows][j];
    for (Index i = 0; i < rows + 2; ++i)
        energy[i][0] = energy[i][1], energy[i][columns + 1] = energy[i][columns];
}

// Writes gray and two differences of color, the planes 27 to 29 of `gradient_cells`.
inline void colors(Samples samples, Volume<float> out) {
    const auto scale = float(1.0 / (double(CELL * CELL) * 255.0));
    ScratchPlane<float> sums(3, out.columns);  // of the cells in a row
    for (Index i = 0; i < out.rows; ++i) {
        std::fill_n(sums.begin(), 3 * out.columns, 0.0f);
        for (Index c = 0; c < 3; ++c) {
            float* __restrict sum = sums[c];
            for (Index row = i * CELL; row < (i + 1) * CELL; ++row) {
                const float* sample = samples[c][row];
                for (Index j = 0; j < out.columns; ++j)
                    for (Index u = 0; u < CELL; ++u) sum[j] += sample[j * CELL + u];
            }
        }
        for (Index j = 0; j < out.columns; ++j) {
            const float red = sums[0][j], green = sums[1][j], blue = sums[2][j];
            out[27][i][j] = float(double((red + green + blue) * scale) / 3 - 0.5);
            out[28][i][j] = (red - green) * scale;
            out[29][i][j] = (0.5f * (red + green) - blue) * scale;
        }
    }
}

// Writes the features (30, h, w) of cells of samples (3, H, W), H = CELL * h, W = CELL * w.
//
// 9 orientations of gradients without and 18 with their sign, each normalized by the energy of the
// four blocks of 2x2 cells around, truncated at 0.2 and averaged (Felzenszwalb et al., section 6);
// then gray and two color differences. `sectors` (512, 512) has the number of a gradient's sector,
// 18 to the turn, at row 256 + dy / 3 and column 256 + dx / 3, the derivatives being those of
// R + G + B.
inline void gradient_cells(Samples samples, Plane<const std::uint8_t> sectors, Volume<float> out) {
    const Index rows = out.rows, columns = out.columns;
    fit(samples.planes == 3 && out.planes == 30 && rows > 0 && columns > 0 &&
            samples.rows == CELL * rows && samples.columns == CELL * columns &&
            sectors.rows == 512 && sectors.columns == 512,
        "samples (3, H, W), cells (30, H / side, W / side) and sectors (512, 512)");
    // One cell more on each side, into which the outermost samples' votes fall.
    ScratchPlane<float> votes(rows + 2, 18 * (columns + 2)), energy(rows + 2, columns + 2);
    vote(samples, sectors, votes);
    energies({votes[0], rows + 2, 18 * (columns + 2)}, energy);
    ScratchPlane<float> norms(4, columns);
    Scratch<float> scratch(columns);
    float* __restrict line = scratch, * __restrict n0 = norms[0], * __restrict n1 = norms[1];
    float* __restrict n2 = norms[2], * __restrict n3 = norms[3];
    for (Index i = 0; i < rows; ++i) {
        const float *above = energy[i], *here = energy[i + 1], *below = energy[i + 2];
        for (Index j = 0; j < columns; ++j) {
            // A gradient of one gray value counts as none.
            const float middle = here[j + 1] + 1.0f;
            n0[j] = 1.0f / std::sqrt(above[j] + above[j + 1] + here[j] + middle);
            n1[j] = 1.0f / std::sqrt(above[j + 2] + above[j + 1] + here[j + 2] + middle);
            n2[j] = 1.0f / std::sqrt(below[j] + below[j + 1] + here[j] + middle);
            n3[j] = 1.0f / std::sqrt(below[j + 2] + below[j + 1] + here[j + 2] + middle);
        }
        for (Index k = 0; k < 27; ++k) {
            const float* one = votes[i + 1] + (k < 9 ? k : k - 9) * (columns + 2) + 1;
            const float* opposite = one + 9 * (columns + 2);
            if (k < 9)
                for (Index j = 0; j < columns; ++j) line[j] = one[j] + opposite[j];
            const float* seen = k < 9 ? line : one;
            float* __restrict to = out[k][i];
            for (Index j = 0; j < columns; ++j)
                to[j] = 0.5f * (std::min(seen[j] * n0[j], 0.2f) + std::min(seen[j] * n1[j], 0.2f) +
                                std::min(seen[j] * n2[j], 0.2f) + std::min(seen[j] * n3[j], 0.2f));
        }
    }
    colors(samples, out);
}

// Writes the features (30 h w, N) of the `rows` x `columns` cells of a target of N sizes, factors
// of the one at its place; those of a size are weighted by its taper.
inline void cells_of_sizes(Picture picture, const Place& place, Floats factors, Taps tapers,
                           Index rows, Index columns, Plane<const std::uint8_t> sectors,
                           Plane<float> out) {
    const Index height = rows * CELL, width = columns * CELL;
    fit(out.rows == 30 * rows * columns && out.columns == factors.size &&
            tapers.size == factors.size,
        "a taper and a column of 30 features a cell for each size");
    Scratch<float> window(3 * height * width), features(out.rows);
    for (Index n = 0; n < factors.size; ++n) {
        const Pair step{2 * place.a * factors[n] / double(width),
                        2 * place.b * factors[n] / double(height)};
        cut_around(picture, place, step, {window, 3, height, width});
        gradient_cells({window, 3, height, width}, sectors, {features, 30, rows, columns});
        for (Index k = 0; k < out.rows; ++k) out[k][n] = tapers[n] * features[k];
    }
}

}  // namespace motes::search_window
