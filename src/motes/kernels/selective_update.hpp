// Keeps for each pixel what it showed when it was last background.
#pragma once

#include <algorithm>

#include "arrays.hpp"

namespace motes::selective_update {

using Bytes = Plane<const std::uint8_t>;

// How long foreground is not learned, in seconds: elsewhere, and in the boxes of known objects.
struct Limits {
    double trial, patience;
};

// Takes a picture's colors into `clean` (3, H, W), but not where it is foreground, up to a limit.
//
// `foreground` and `known` are 1 or 0; `since` is when a pixel was last background, in seconds.
inline void update(Volume<const std::uint8_t> picture, Bytes foreground, Bytes known, double time,
                   Limits limits, Plane<double> since, Volume<std::uint8_t> clean) {
    const Index width = picture.columns;
    fit(picture.planes == 3 && clean.planes == 3 &&
            same_size(picture, foreground, known, since, clean),
        "a picture, masks and times of one size");
    Scratch<std::uint8_t> room(width);
    std::uint8_t* __restrict held = room;
    for (Index y = 0; y < picture.rows; ++y) {
        const std::uint8_t *mask = foreground[y], *here = known[y];
        double* __restrict last = since[y];
        for (Index x = 0; x < width; ++x) {
            last[x] = mask[x] ? last[x] : time;
            const double limit = here[x] ? limits.patience : limits.trial;
            held[x] = std::uint8_t((mask[x] != 0) & (time - last[x] < limit));
        }
        for (Index c = 0; c < 3; ++c) {
            const std::uint8_t* now = picture[c][y];
            std::uint8_t* __restrict kept = clean[c][y];
            for (Index x = 0; x < width; ++x) kept[x] = held[x] ? kept[x] : now[x];
        }
    }
}

}  // namespace motes::selective_update
