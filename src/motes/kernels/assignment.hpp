// Rows and columns paired one to one, at the least cost in all.
#pragma once

#include <algorithm>
#include <limits>
#include <utility>

#include "arrays.hpp"

namespace motes::assignment {

// Returns the column of each row of costs (n, m), n <= m, all of them finite.
//
// The Hungarian method: rows come one by one. Each looks for the shortest path to a free column, by
// Dijkstra's algorithm, on which pairs to be made and pairs to be given up take turns. Prices of
// rows and columns keep all reduced costs from falling below 0.
inline Scratch<Index> least_cost(Plane<const double> costs) {
    const Index count = costs.columns;
    Scratch<double> row_scratch(costs.rows), column_scratch(count), distance(count);
    Scratch<Index> owner(count), before(count), out(costs.rows);
    Scratch<bool> near(count);
    double *row_price = row_scratch, *column_price = column_scratch, *to = distance;
    Index *own = owner, *from = before;
    bool* settled = near;
    std::fill_n(row_price, costs.rows, 0.0);
    std::fill_n(column_price, count, 0.0);
    std::fill_n(own, count, Index(-1));
    std::fill_n(out.begin(), costs.rows, Index(-1));
    for (Index first = 0; first < costs.rows; ++first) {
        std::fill_n(to, count, std::numeric_limits<double>::infinity());
        std::fill_n(settled, count, false);
        double length = 0.0;
        Index row = first, end;
        for (;; row = own[end]) {
            end = -1;
            for (Index j = 0; j < count; ++j) {
                if (settled[j]) continue;
                const double next = length + costs[row][j] - row_price[row] - column_price[j];
                if (next < to[j]) to[j] = next, from[j] = row;
                const bool freer = end >= 0 && to[j] == to[end] && own[j] < 0 && own[end] >= 0;
                if (end < 0 || to[j] < to[end] || freer) end = j;
            }
            settled[end] = true, length = to[end];
            if (own[end] < 0) break;
        }
        row_price[first] += length;
        for (Index j = 0; j < count; ++j) {
            if (!settled[j] || j == end) continue;
            row_price[own[j]] += length - to[j];
            column_price[j] -= length - to[j];
        }
        do {
            row = own[end] = from[end];
            std::swap(out.begin()[row], end);
        } while (row != first);
    }
    return out;
}

}  // namespace motes::assignment
