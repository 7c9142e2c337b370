// How strong the edges are along the outlines of patches, in two pictures.
#pragma once

#include <algorithm>
#include <cstdlib>

#include "arrays.hpp"

namespace motes::ghosts {

using Bytes = Plane<const std::uint8_t>;

// Returns the sum of the gradients in x and y of values at(y, x) where a mask is; past its border
// they repeat.
template <typename At>
int gradient(At at, Bytes mask, Index y, Index x) {
    const Index above = std::max<Index>(y - 1, 0), below = std::min(y + 1, mask.rows - 1);
    const Index left = std::max<Index>(x - 1, 0), right = std::min(x + 1, mask.columns - 1);
    return std::abs(at(below, x) - at(above, x)) + std::abs(at(y, right) - at(y, left));
}

// Writes 1 for the pixels of a row, from `left` to before `right`, that have a neighbor beside,
// above or below which a mask treats otherwise, else 0.
inline void outline(Bytes mask, Index y, Index left, Index right, std::uint8_t* __restrict out) {
    const Index last = mask.columns - 1;
    const std::uint8_t *here = mask[y], *above = mask[std::max<Index>(y - 1, 0)],
                       *below = mask[std::min(y + 1, mask.rows - 1)];
    for (Index x = left; x < right; ++x)
        out[x] = std::uint8_t((here[x] ^ above[x]) | (here[x] ^ below[x]));
    for (Index x = std::max<Index>(left, 1); x < right; ++x) out[x] |= here[x] ^ here[x - 1];
    for (Index x = left; x < std::min(right, last); ++x) out[x] |= here[x] ^ here[x + 1];
}

// Writes for each box (left, top, width, height) the sums of the gradients of a picture's green,
// and of the learned one, over the pixels on both sides of the mask's outline, in the box and one
// pixel around it.
inline void outline_gradients(Bytes mask, Picture now, Bytes learned,
                              Plane<const std::int64_t> boxes, Plane<double> out) {
    fit(now.height == mask.rows && now.width == mask.columns && same_size(mask, learned) &&
            boxes.columns == 4 && out.rows == boxes.rows && out.columns == 2,
        "a mask, a picture and a plane of one size, boxes, and two sums for each");
    const auto seen = [&](Index y, Index x) {
        return int(now.row(y)[x * now.pixel + now.green()]);
    };
    const auto usual = [&](Index y, Index x) { return int(learned[y][x]); };
    Scratch<std::uint8_t> edges(mask.columns);
    for (Index i = 0; i < boxes.rows; ++i) {
        const Index x = boxes[i][0], y = boxes[i][1], w = boxes[i][2], h = boxes[i][3];
        const Index left = std::max<Index>(x - 1, 0), right = std::min(x + w + 1, mask.columns);
        const Index top = std::max<Index>(y - 1, 0), bottom = std::min(y + h + 1, mask.rows);
        Index sums[] = {0, 0};
        for (Index row = top; row < bottom; ++row) {
            outline(mask, row, left, right, edges);
            for (Index at = left; at < right; ++at) {
                if (!edges[at]) continue;
                sums[0] += gradient(seen, mask, row, at);
                sums[1] += gradient(usual, mask, row, at);
            }
        }
        out[i][0] = double(sums[0]), out[i][1] = double(sums[1]);
    }
}

}  // namespace motes::ghosts
