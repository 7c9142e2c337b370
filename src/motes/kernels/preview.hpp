// The usual colors of each pixel in a few pictures of a camera at rest.
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "arrays.hpp"

namespace motes::preview {

constexpr Index MOST = 31;                  // pictures
constexpr Index PART = 32;                  // pixels of a row that are looked at together
constexpr int BITS = 5, CODES = 1 << BITS;  // a number from 0 to 31 tells a picture

using Keys = std::int16_t[MOST][PART];  // brightness * CODES + code of the picture

// Returns the picture of a code: those at both ends of the time come first, then inwards.
inline std::int16_t time_of(std::int16_t code, std::int16_t pictures) {
    const auto inwards = std::int16_t(code >> 1);
    return code & 1 ? std::int16_t(pictures - 1 - inwards) : inwards;
}

// Batcher's network: pairs of places whose values are put in order, one pair after the other.
inline std::vector<std::pair<Index, Index>> sorting_network(Index count) {
    std::vector<std::pair<Index, Index>> pairs;
    for (Index p = 1; p < count; p *= 2)
        for (Index k = p; k >= 1; k /= 2)
            for (Index j = k % p; j + k < count; j += 2 * k)
                for (Index i = j; i < std::min(j + k, count - k); ++i)
                    if (i / (2 * p) == (i + k) / (2 * p)) pairs.emplace_back(i, i + k);
    return pairs;
}

// Puts two rows of keys in order, column by column.
inline void in_order(std::int16_t* __restrict low, std::int16_t* __restrict high) {
    for (Index x = 0; x < PART; ++x) {
        const std::int16_t one = low[x], other = high[x];
        low[x] = one < other ? one : other;
        high[x] = one < other ? other : one;
    }
}

// Writes for each column of sorted keys where the `group` keys begin whose brightness is closest
// together, of those that do not lie within half of the time, if there are any.
inline void closest(const Keys keys, Index count, Index group, std::int16_t* __restrict starts) {
    constexpr std::int16_t PASSING = 3 * 256;  // more than any difference
    const auto pictures = std::int16_t(count);
    std::int16_t least[PART];
    std::fill_n(least, PART, std::int16_t(2 * PASSING));
    for (Index i = 0; i + group <= count; ++i) {
        std::int16_t first[PART], last[PART];
        std::fill_n(first, PART, std::int16_t(count));
        std::fill_n(last, PART, std::int16_t(-1));
        for (Index k = i; k < i + group; ++k)
            for (Index x = 0; x < PART; ++x) {
                const std::int16_t time = time_of(keys[k][x] & (CODES - 1), pictures);
                first[x] = std::min(first[x], time);
                last[x] = std::max(last[x], time);
            }
        const std::int16_t *low = keys[i], *high = keys[i + group - 1];
        for (Index x = 0; x < PART; ++x) {
            const auto time = std::int16_t(2 * (last[x] - first[x]));
            const std::int16_t passing = time < pictures ? PASSING : std::int16_t(0);
            const auto apart = std::int16_t((high[x] >> BITS) - (low[x] >> BITS) + passing);
            starts[x] = apart < least[x] ? std::int16_t(i) : starts[x];
            least[x] = apart < least[x] ? apart : least[x];
        }
    }
}

// Writes the mean colors of a group of the pictures (n, h, 3 w), for each pixel of its own: those
// whose brightness is closest together, and which do not lie within half of the time.
inline void usual_colors(Volume<const std::uint8_t> pictures, Index group,
                         Plane<std::uint8_t> out) {
    const Index count = pictures.planes, width = pictures.columns / 3;
    const auto time = [=](Index code) { return time_of(std::int16_t(code), std::int16_t(count)); };
    fit(0 < count && count <= MOST && 0 < group && group <= count &&
            pictures.columns == 3 * width && out.rows == pictures.rows &&
            out.columns == pictures.columns,
        "up to 31 pictures of red, green and blue, no more in a group, and a picture to write");
    const auto network = sorting_network(count);
    Keys keys = {};
    std::int16_t starts[PART];
    for (Index y = 0; y < pictures.rows; ++y)
        for (Index left = 0; left < width; left += PART) {
            const Index pixels = std::min(PART, width - left);
            for (Index code = 0; code < count; ++code) {
                const std::uint8_t* from = pictures[time(code)][y] + 3 * left;
                for (Index x = 0; x < pixels; ++x, from += 3)
                    keys[code][x] = std::int16_t((from[0] + from[1] + from[2]) * CODES + code);
            }
            for (const auto& [low, high] : network) in_order(keys[low], keys[high]);
            closest(keys, count, group, starts);
            std::uint8_t* to = out[y] + 3 * left;
            for (Index x = 0; x < pixels; ++x, to += 3) {
                int sums[3] = {};
                for (Index k = starts[x]; k < starts[x] + group; ++k) {
                    const Index code = keys[k][x] & (CODES - 1);
                    const std::uint8_t* from = pictures[time(code)][y] + 3 * (left + x);
                    for (Index c = 0; c < 3; ++c) sums[c] += from[c];
                }
                for (Index c = 0; c < 3; ++c)
                    to[c] = std::uint8_t(std::nearbyint(double(sums[c]) / double(group)));
            }
        }
}

}  // namespace motes::preview
