// Gray values and their derivatives, of a region and at single pixels, and angles.
//
// Filters are given by their taps at 0 … r. Past the border of the image its pixels repeat.
#pragma once

#include "sampling.hpp"

namespace motes::gradients {

// Writes 256 times the luma at each byte of `count` from a row, as if each began a pixel.
//
// Every third is of use: three times the work in less time, since it is vector code.
inline void luma(const Picture& picture, const std::uint8_t* bytes, std::uint16_t* __restrict out,
                 Index count) {
    const std::uint8_t *red = bytes + picture.red(), *green = bytes + picture.green();
    const std::uint8_t* blue = bytes + picture.blue();
    for (Index i = 0; i < count; ++i)
        out[i] = std::uint16_t(77 * red[i] + 150 * green[i] + 29 * blue[i]);
}

// Writes `inner` of the values, `step` apart, times `share`.
template <typename T>
void take(const T* values, Index step, Index inner, float share, float* __restrict out) {
    for (Index x = 0; x < inner; ++x) out[x] = share * float(std::int32_t(values[step * x]));
}

// Writes the values of pixels times `share`, after `before` copies of the first, then the last.
template <typename T>
void every_pixel(const T* values, Index pixel, Index inner, float share, Index before,
                 float* __restrict out, Index size) {
    float* middle = out + before;
    if (pixel == 3)  // known when this is compiled, and vector code
        take(values, 3, inner, share, middle);
    else
        take(values, pixel, inner, share, middle);
    std::fill(out, middle, middle[0]);
    std::fill(middle + inner, out + size, middle[inner - 1]);
}

inline Index within(Index value, Index least, Index most) {
    return std::min(std::max(value, least), most);
}

// Writes the luma of a region's pixels.
[[gnu::noinline]] inline void gray_values(Picture picture, Index left, Index top,
                                          Plane<float> gray) {
    const Index width = picture.width;
    const Index first = within(left, 0, width - 1);
    const Index last = within(left + gray.columns, 1, width);
    const Index pixel = picture.pixel, inner = last - first, count = pixel * (inner - 1) + 1;
    Scratch<std::uint16_t> line(count);
    for (Index i = 0; i < gray.rows; ++i) {
        const Index y = within(top + i, 0, picture.height - 1);
        luma(picture, picture.row(y) + pixel * first, line, count);
        every_pixel<std::uint16_t>(line, pixel, inner, 1.0f / 256, first - left, gray[i],
                                   gray.columns);
    }
}

// Writes the mean luma of blocks of step x step pixels.
[[gnu::noinline]] inline void gray_blocks(Picture picture, Index left, Index top, Index step,
                                          Plane<float> gray) {
    const Index width = picture.width, across = gray.columns * step;
    const Index first = within(left, 0, width - 1);
    const Index last = within(left + across, 1, width);
    const Index pixel = picture.pixel, inner = last - first, count = pixel * (inner - 1) + 1;
    Scratch<std::uint16_t> line(count);
    Scratch<std::uint32_t> sums(count);
    Scratch<float> pixels(across);
    const float share = float(1.0 / double(256 * step * step));
    for (Index i = 0; i < gray.rows; ++i) {
        std::fill_n(static_cast<std::uint32_t*>(sums), count, 0u);
        for (Index y = top + i * step; y < top + (i + 1) * step; ++y) {
            const Index row = within(y, 0, picture.height - 1);
            luma(picture, picture.row(row) + pixel * first, line, count);
            for (Index x = 0; x < count; ++x) sums[x] += line[x];
        }
        every_pixel<std::uint32_t>(sums, pixel, inner, share, first - left, pixels, across);
        for (Index j = 0; j < gray.columns; ++j) {
            float total = 0.0f;
            for (Index x = j * step; x < (j + 1) * step; ++x) total += pixels[x];
            gray[i][j] = total;
        }
    }
}

// Writes the rows of `source` filtered by taps at 0 … r, at -k `sign` times those at k.
[[gnu::noinline]] inline void along_rows(Plane<const float> source, Taps taps, float sign,
                                         Plane<float> out) {
    const Index r = taps.size - 1;
    for (Index y = 0; y < out.rows; ++y) {
        float* __restrict line = out[y];
        const float* middle = source[y] + r;
        for (Index x = 0; x < out.columns; ++x) line[x] = taps[0] * middle[x];
        for (Index k = 1; k <= r; ++k) {
            const float tap = taps[k];
            for (Index x = 0; x < out.columns; ++x)
                line[x] += tap * (middle[x + k] + sign * middle[x - k]);
        }
    }
}

// Writes the columns of `source` filtered, as `along_rows` does with rows.
[[gnu::noinline]] inline void along_columns(Plane<const float> source, Taps taps, float sign,
                                            Plane<float> out) {
    const Index r = taps.size - 1;
    for (Index y = 0; y < out.rows; ++y) {
        float* __restrict line = out[y];
        const float* middle = source[y + r];
        for (Index x = 0; x < out.columns; ++x) line[x] = taps[0] * middle[x];
        for (Index k = 1; k <= r; ++k) {
            const float tap = taps[k];
            const float *after = source[y + r + k], *before = source[y + r - k];
            for (Index x = 0; x < out.columns; ++x) line[x] += tap * (after[x] + sign * before[x]);
        }
    }
}

template <typename T>
Plane<const T> read_only(Plane<T> plane) {
    return {plane.data, plane.rows, plane.columns};
}

// Writes the two derivatives of a region's gray values, in blocks of step x step pixels.
[[gnu::noinline]] inline void derivatives(Picture picture, Index left, Index top, Index step,
                                          Taps smooth, Taps derivative, Plane<float> gx,
                                          Plane<float> gy) {
    const Index height = gx.rows, width = gx.columns, margin = smooth.size - 1;
    ScratchPlane<float> gray(height + 2 * margin, width + 2 * margin);
    if (step == 1)
        gray_values(picture, left - margin, top - margin, gray);
    else
        gray_blocks(picture, left - margin * step, top - margin * step, step, gray);
    ScratchPlane<float> rows(height + 2 * margin, width);
    along_rows(read_only<float>(gray), derivative, -1.0f, rows);
    along_columns(read_only<float>(rows), smooth, 1.0f, gx);
    along_rows(read_only<float>(gray), smooth, 1.0f, rows);
    along_columns(read_only<float>(rows), derivative, -1.0f, gy);
}

// Writes the two derivatives of gray values at pixels, by their places in the image.
class DerivativesAt {
public:
    DerivativesAt(Picture picture, Taps smooth, Taps derivative, Index room)
        : picture_(picture),
          smooth_(smooth),
          derivative_(derivative),
          columns_(2 * smooth.size - 1, room),
          rows_(2 * smooth.size - 1, room),
          offsets_(room),
          colors_(room) {}

    void operator()(const std::uint32_t* places, Index count, float* __restrict gx,
                    float* __restrict gy) const {
        const Index r = smooth_.size - 1;
        const auto width = std::int32_t(picture_.width);
        const auto line = std::int32_t(picture_.line), pixel = std::int32_t(picture_.pixel);
        const auto last = width - 1, bottom = std::int32_t(picture_.height) - 1;
        std::int32_t *row = rows_[r], *column = columns_[r];
        for (Index i = 0; i < count; ++i) {  // by division in double precision, which is exact
            row[i] = std::int32_t(double(places[i]) / double(width));
            column[i] = std::int32_t(places[i]) - row[i] * width;
            gx[i] = gy[i] = 0.0f;
        }
        for (Index k = 0; k <= 2 * r; ++k) {
            if (k == r) continue;
            const auto off = std::int32_t(k - r);
            std::int32_t* __restrict to_row = rows_[k];
            std::int32_t* __restrict to_column = columns_[k];
            for (Index i = 0; i < count; ++i) {
                to_row[i] = std::min(std::max(row[i] + off, 0), bottom) * line;
                to_column[i] = std::min(std::max(column[i] + off, 0), last) * pixel;
            }
        }
        for (Index i = 0; i < count; ++i) row[i] *= line, column[i] *= pixel;
        for (Index dy = -r; dy <= r; ++dy)
            for (Index dx = -r; dx <= r; ++dx) add(dx, dy, count, gx, gy);
    }

private:
    // Adds to both derivatives what the pixels dx and dy away have in them.
    void add(Index dx, Index dy, Index count, float* __restrict gx, float* __restrict gy) const {
        const auto sign = [](Index n) { return float((n > 0) - (n < 0)); };
        const Index r = smooth_.size - 1, across = std::abs(dx), down = std::abs(dy);
        const float share = 1.0f / 256;
        const float to_x = sign(dx) * derivative_[across] * smooth_[down] * share;
        const float to_y = sign(dy) * derivative_[down] * smooth_[across] * share;
        if (to_x == 0.0f && to_y == 0.0f) return;
        const std::int32_t *x = columns_[dx + r], *y = rows_[dy + r];
        std::uint32_t* __restrict offsets = offsets_;
        std::uint32_t* __restrict colors = colors_;
        for (Index i = 0; i < count; ++i) offsets[i] = std::uint32_t(x[i] + y[i]);
        sampling::colors_at(picture_, offsets, count, colors);
        for (Index i = 0; i < count; ++i) {
            const std::uint32_t c = colors[i];
            const auto value =
                float(std::int32_t(77 * (c & 255) + 150 * ((c >> 8) & 255) + 29 * (c >> 16)));
            gx[i] += to_x * value;
            gy[i] += to_y * value;
        }
    }

    Picture picture_;
    Taps smooth_, derivative_;
    ScratchPlane<std::int32_t> columns_, rows_;
    Scratch<std::uint32_t> offsets_, colors_;
};

// Returns the angle of (x, y) as a share of a turn, from 0 at (-1, -0) up to 1 at (-1, 0).
//
// A polynomial for the arctangent up to 1/8 turn (Abramowitz and Stegun 4.4.49, error under 1.2e-5
// radians) and three reflections, all without branches, so that it becomes vector code.
inline float turn(float y, float x) {
    const float across = std::fabs(x), up = std::fabs(y);
    const float most = std::max(across, up);
    const float t = std::min(across, up) / (most > 0.0f ? most : 1.0f);
    const float s = t * t;
    float angle = t * (0.9998660f +
                       s * (-0.3302995f + s * (0.1801410f + s * (-0.0851330f + s * 0.0208351f))));
    angle *= float(0.5 / 3.14159265358979323846);
    angle = up > across ? 0.25f - angle : angle;
    angle = x < 0.0f ? 0.5f - angle : angle;
    return 0.5f + (y >= 0.0f ? angle : -angle);
}

// Writes the angles of (x, y), as `turn` returns them.
inline void turns(Row<const float> y, Row<const float> x, Row<float> out) {
    for (Index i = 0; i < out.size; ++i) out[i] = turn(y[i], x[i]);
}

}  // namespace motes::gradients
