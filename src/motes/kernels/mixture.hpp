// A mixture of Gaussians for each pixel: Stauffer and Grimson, CVPR 1999; Zivkovic, ICPR 2004.
//
// A mode has a weight, a variance and the means of three colors; modes are sorted by weight, and
// one that is not used has none. A model is (MODES, parts, FIELDS * PART): each mode of the whole
// picture lies in one piece, as later modes are seldom used, and then need no memory.
#pragma once

#include <algorithm>
#include <utility>

#include "arrays.hpp"

namespace motes::mixture {

constexpr Index MODES = 5, FIELDS = 5;
constexpr Index PART = 32;  // pixels of a row that are looked at together

// How a mixture learns; see `mixture.Mixture`.
struct Learning {
    double rate, prune, near, first, least, most;
};

// The mixture of a pixel in the model of its row: its first number, and those to the next mode.
struct Mixture {
    float* data;
    Index step;

    float& weight(Index mode) const { return at(mode, 0); }
    float& variance(Index mode) const { return at(mode, 1); }
    float& mean(Index mode, Index color) const { return at(mode, 2 + color); }
    float& at(Index mode, Index field) const { return data[mode * step + field * PART]; }

    Index used() const {
        Index count = 0;
        while (count < MODES && weight(count) > 0) ++count;
        return count;
    }
    // Returns the squared distance of a color from a mode's mean.
    float distance(Index mode, const float* color) const {
        const float r = mean(mode, 0) - color[0], g = mean(mode, 1) - color[1],
                    b = mean(mode, 2) - color[2];
        return r * r + g * g + b * b;
    }
    // Moves a mode before those of less weight.
    Index sorted(Index mode) const {
        for (; mode > 0 && weight(mode) >= weight(mode - 1); --mode)
            for (Index field = 0; field < FIELDS; ++field)
                std::swap(at(mode, field), at(mode - 1, field));
        return mode;
    }
    void divide_weights() const {
        const Index count = used();
        float total = 0;
        for (Index mode = 0; mode < count; ++mode) total += weight(mode);
        for (Index mode = 0; mode < count; ++mode) weight(mode) /= total;
    }
};

// A mode of the pixels of a part of a row.
struct Modes {
    float* __restrict weight, * __restrict variance;
    float* __restrict red, * __restrict green, * __restrict blue;

    Modes(Volume<float> model, Index mode, Index part)
        : weight(model[mode][part]),
          variance(weight + PART),
          red(variance + PART),
          green(red + PART),
          blue(green + PART) {}

    float distance(Index i, const std::uint8_t* r, const std::uint8_t* g,
                   const std::uint8_t* b) const {
        const float dr = red[i] - float(r[i]), dg = green[i] - float(g[i]),
                    db = blue[i] - float(b[i]);
        return dr * dr + dg * dg + db * db;
    }
};

// Checks that a model is that of pictures of a size.
inline void check(Volume<float> model, Index planes, Index height, Index width) {
    motes::fit(planes == 3 && model.planes == MODES &&
                   model.rows == height * ((width + PART - 1) / PART) &&
                   model.columns == FIELDS * PART,
               "three planes, and the model of their size");
}

// Asks memory for a mode of the part after the next, its first `fields`, so that nobody waits
// there.
inline void ask_ahead([[maybe_unused]] Volume<float> model, [[maybe_unused]] Index mode,
                      [[maybe_unused]] Index part, [[maybe_unused]] Index fields) {
#ifdef __GNUC__
    const float* later = model[mode][part + 2];  // at the end, one of the next mode
    for (Index i = 0; i < fields * PART; i += 16) __builtin_prefetch(later + i);
#endif
}

// Writes 1 where a picture is foreground: no mode of the background is near, else 0.
//
// Modes of the background are the first ones whose weights add up to `share`. A color is near one
// up to a squared distance of `limit` variances. Later modes are read only for the part of a row in
// which the first ones leave a pixel open.
inline void foreground(Volume<float> model, Volume<const std::uint8_t> picture, double share,
                       double limit, Plane<std::uint8_t> out) {
    check(model, picture.planes, out.rows, out.columns);
    motes::fit(same_size(picture, out), "a picture and a mask of one size");
    const auto far = float(limit), enough = float(share);
    for (Index y = 0, at = 0; y < out.rows; ++y)
        for (Index begin = 0; begin < out.columns; begin += PART, ++at) {
            const Index size = std::min(PART, out.columns - begin);
            const std::uint8_t *r = picture[0][y] + begin, *g = picture[1][y] + begin,
                               *b = picture[2][y] + begin;
            ask_ahead(model, 0, at, FIELDS);
            float sum[PART] = {};
            std::uint8_t apart[PART];
            std::fill_n(apart, PART, std::uint8_t(1));
            bool open = true;
            for (Index mode = 0; mode < MODES && open; ++mode) {
                const Modes part(model, mode, at);
                int more = 0;
                for (Index i = 0; i < size; ++i) {
                    const bool asked = (sum[i] < enough) & (part.weight[i] > 0);
                    const bool near = part.distance(i, r, g, b) < far * part.variance[i];
                    apart[i] &= std::uint8_t(!(asked & near));
                    sum[i] += part.weight[i];
                    more |= apart[i] & int(sum[i] < enough);
                }
                open = more != 0;
            }
            std::copy_n(apart, size, out[y] + begin);
        }
}

// Moves a mode toward a color, whose squared distance is `squared`, and gives it more weight.
inline void fit(Mixture pixel, Index mode, const float* color, float squared, const Learning& how) {
    const auto rate = float(how.rate), least = float(how.least), most = float(how.most);
    pixel.weight(mode) += rate;
    const float part = rate / pixel.weight(mode);
    for (Index c = 0; c < 3; ++c) pixel.mean(mode, c) += part * (color[c] - pixel.mean(mode, c));
    const float variance = pixel.variance(mode) + part * (squared - pixel.variance(mode));
    pixel.variance(mode) = std::min(std::max(variance, least), most);
}

// Learns a color (Zivkovic, equations 4 to 6 and 14): the first mode that is near moves toward it,
// all others lose weight, those without any are removed; where none is near a mode begins.
inline void learn(Mixture pixel, const float* color, const Learning& how) {
    const auto rate = float(how.rate), prune = float(how.rate * how.prune);
    Index count = pixel.used(), chosen = -1;
    for (Index mode = 0; mode < count && chosen < 0; ++mode)
        if (pixel.distance(mode, color) < float(how.near) * pixel.variance(mode)) chosen = mode;
    for (Index mode = 0; mode < count; ++mode)
        pixel.weight(mode) = (1 - rate) * pixel.weight(mode) - prune;
    if (chosen >= 0) {
        fit(pixel, chosen, color, pixel.distance(chosen, color), how);
        pixel.sorted(chosen);
    }
    while (count > 0 && pixel.weight(count - 1) < prune) pixel.weight(--count) = 0;
    pixel.divide_weights();
    if (chosen >= 0) return;
    const Index fresh = std::min(count, MODES - 1);
    for (Index mode = 0; mode < fresh; ++mode) pixel.weight(mode) *= 1 - rate;
    pixel.weight(fresh) = fresh == 0 ? 1 : rate;
    pixel.variance(fresh) = float(how.first);
    for (Index c = 0; c < 3; ++c) pixel.mean(fresh, c) = color[c];
    pixel.sorted(fresh);
}

// Learns part of a row for the pixels that are near their first mode, as `learn` does for one; most
// are. It keeps its place as the first, so that all go through the same steps. Writes which do.
inline void learn_first(Volume<float> model, Index at, Index size, const std::uint8_t* r,
                        const std::uint8_t* g, const std::uint8_t* b, const Learning& how,
                        std::uint8_t* __restrict done) {
    const auto rate = float(how.rate), prune = float(how.rate * how.prune), near = float(how.near);
    const auto least = float(how.least), most = float(how.most), keep = 1 - rate;
    const Modes first(model, 0, at);
    ask_ahead(model, 0, at, FIELDS);
    ask_ahead(model, 1, at, 1);
    float total[PART];
    for (Index i = 0; i < size; ++i) {
        const float squared = first.distance(i, r, g, b), variance = first.variance[i];
        const bool fits = (first.weight[i] > 0) & (squared < near * variance);
        const float weight = (keep * first.weight[i] - prune) + rate, part = rate / weight;
        const float spread = variance + part * (squared - variance);
        const float shift = fits ? part : 0;
        done[i] = std::uint8_t(fits);
        total[i] = weight;
        first.red[i] += shift * (float(r[i]) - first.red[i]);
        first.green[i] += shift * (float(g[i]) - first.green[i]);
        first.blue[i] += shift * (float(b[i]) - first.blue[i]);
        first.variance[i] = fits ? std::min(std::max(spread, least), most) : variance;
        first.weight[i] = fits ? weight : first.weight[i];
    }
    Index used = 1;  // modes that any pixel has
    for (; used < MODES; ++used) {
        const Modes other(model, used, at);
        int any = 0;  // vector code, as `std::any_of` is not
        for (Index i = 0; i < size; ++i) any |= int(other.weight[i] > 0);
        if (!any) break;
        for (Index i = 0; i < size; ++i) {
            const float less = keep * other.weight[i] - prune;
            const float weight = (other.weight[i] > 0) & (less >= prune) ? less : 0;
            other.weight[i] = done[i] ? weight : other.weight[i];
            total[i] += weight;
        }
    }
    for (Index mode = 0; mode < used; ++mode) {
        const Modes each(model, mode, at);
        for (Index i = 0; i < size; ++i) each.weight[i] /= done[i] ? total[i] : 1;
    }
}

// Learns a picture.
inline void learn_picture(Volume<float> model, Volume<const std::uint8_t> picture, Learning how) {
    const Index width = picture.columns;
    check(model, picture.planes, picture.rows, width);
    for (Index y = 0, at = 0; y < picture.rows; ++y)
        for (Index begin = 0; begin < width; begin += PART, ++at) {
            const Index size = std::min(PART, width - begin);
            const std::uint8_t *r = picture[0][y] + begin, *g = picture[1][y] + begin,
                               *b = picture[2][y] + begin;
            std::uint8_t done[PART];
            learn_first(model, at, size, r, g, b, how, done);
            for (Index i = 0; i < size; ++i) {
                if (done[i]) continue;
                const float color[] = {float(r[i]), float(g[i]), float(b[i])};
                learn({model[0][at] + i, model.rows * model.columns}, color, how);
            }
        }
}

// Writes the mean colors of the background, of the modes whose weights add up to `share`.
inline void means(Volume<float> model, double share, Volume<std::uint8_t> out) {
    check(model, out.planes, out.rows, out.columns);
    const auto enough = float(share);
    for (Index y = 0, at = 0; y < out.rows; ++y)
        for (Index begin = 0; begin < out.columns; begin += PART, ++at) {
            const Index size = std::min(PART, out.columns - begin);
            ask_ahead(model, 0, at, FIELDS);
            float sum[PART] = {}, red[PART] = {}, green[PART] = {}, blue[PART] = {};
            bool open = true;
            for (Index mode = 0; mode < MODES && open; ++mode) {
                const Modes part(model, mode, at);
                int more = 0;
                for (Index i = 0; i < size; ++i) {
                    const float weight = sum[i] < enough ? part.weight[i] : 0;
                    red[i] += weight * part.red[i];
                    green[i] += weight * part.green[i];
                    blue[i] += weight * part.blue[i];
                    sum[i] += weight;
                    more |= int(sum[i] < enough);
                }
                open = more != 0;
            }
            std::uint8_t* __restrict to[] = {out[0][y] + begin, out[1][y] + begin,
                                             out[2][y] + begin};
            for (Index i = 0; i < size; ++i) {
                to[0][i] = std::uint8_t(red[i] / sum[i] + 0.5f);
                to[1][i] = std::uint8_t(green[i] / sum[i] + 0.5f);
                to[2][i] = std::uint8_t(blue[i] / sum[i] + 0.5f);
            }
        }
}

}  // namespace motes::mixture
