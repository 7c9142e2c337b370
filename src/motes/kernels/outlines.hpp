// Where the upper outline of a patch has valleys: between heads, and between roofs.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "components.hpp"

namespace motes::outlines {

using Heights = std::vector<Index>;

// Returns the least or largest height around each column, in a window of `half` columns to each
// side; `first` is std::less or std::greater.
template <typename Before>
Heights filtered(const Heights& heights, Index half, Before before) {
    const auto size = Index(heights.size());
    Heights out(heights.size());
    for (Index x = 0; x < size; ++x) {
        const auto begin = heights.begin() + std::max<Index>(x - half, 0);
        const auto end = heights.begin() + std::min(x + half + 1, size);
        out[std::size_t(x)] = *std::min_element(begin, end, before);
    }
    return out;
}

// Returns how high a patch (h, w) reaches over its lowest row in each column, 0 where it is not.
inline Heights upper_outline(Plane<const std::uint8_t> patch) {
    Heights out(std::size_t(patch.columns), 0);
    for (Index y = patch.rows - 1; y >= 0; --y)
        for (Index x = 0; x < patch.columns; ++x)
            if (patch[y][x]) out[std::size_t(x)] = patch.rows - y;
    return out;
}

// Returns the column of the deepest valley from `left` to before `right`, or -1 if none is deeper
// than `deep`, a share of the lower one of the peaks on both sides.
//
// Columns nearer than `least` to the ends have none. A valley's floor is divided in its middle.
inline Index deepest_valley(const Heights& heights, Index left, Index right, Index least,
                            double deep) {
    if (right - left < 2 * least) return -1;
    const auto at = [&](Index x) { return heights[std::size_t(x)]; };
    Heights lower(std::size_t(right - left));
    for (Index x = left, peak = 0; x < right; ++x)
        lower[std::size_t(x - left)] = peak = std::max(peak, at(x));
    double depth = deep;
    Index begin = -1, end = -1;
    std::vector<double> depths(std::size_t(right - left), 0.0);
    for (Index x = right - 1, peak = 0; x >= left; --x) {
        peak = std::max(peak, at(x));
        const Index side = std::max<Index>(std::min(peak, lower[std::size_t(x - left)]), 1);
        if (x - left >= least && right - x > least)
            depths[std::size_t(x - left)] = 1.0 - double(at(x)) / double(side);
    }
    for (Index x = left; x < right; ++x) {
        const double here = depths[std::size_t(x - left)];
        if (here > depth)
            depth = here, begin = x, end = x + 1;
        else if (begin >= 0 && here == depth && x == end)
            ++end;
    }
    return begin < 0 ? -1 : begin + (end - begin) / 2;
}

// Returns the parts into which valleys divide a patch, in their order: left, top, width and height
// of the box around the pixels of each, and their number.
//
// Peaks narrower than `spike` columns, an odd number, are no heads; see `blobs.divided`.
inline ScratchPlane<Index> divided(Plane<const std::uint8_t> patch, Index spike, double valley,
                                   Index narrow) {
    const Heights low = filtered(upper_outline(patch), spike / 2, std::less<Index>());
    const Heights heights = filtered(low, spike / 2, std::greater<Index>());
    Heights ends{0};
    std::vector<std::pair<Index, Index>> parts{{0, patch.columns}};
    while (!parts.empty()) {  // from left to right
        const auto [left, right] = parts.back();
        parts.pop_back();
        const Index cut = deepest_valley(heights, left, right, narrow, valley);
        if (cut < 0)
            ends.push_back(right);
        else
            parts.insert(parts.end(), {{cut, right}, {left, cut}});
    }
    ScratchPlane<Index> out(Index(ends.size()) - 1, 5);
    for (Index k = 0; k < out.rows(); ++k) {
        const Index begin = ends[std::size_t(k)], end = ends[std::size_t(k + 1)];
        Index left = end, right = begin, top = patch.rows, bottom = 0, count = 0;
        for (Index y = 0; y < patch.rows; ++y) {
            const std::uint8_t* row = patch[y];
            const Index first = components::next(row, begin, end, 1);
            if (first == end) continue;
            for (Index x = end; x > right; --x)
                if (row[x - 1]) right = x;
            left = std::min(left, first), top = std::min(top, y), bottom = y + 1;
            int own = 0;  // vector code, as `std::count` is not
            for (Index x = first; x < end; ++x) own += row[x];
            count += own;
        }
        const Index part[] = {left, top, right - left, bottom - top, count};
        std::copy_n(part, 5, out[k]);
    }
    return out;
}

}  // namespace motes::outlines
