// Connected parts of a mask, by its runs: pixels of one value beside each other in a row.
#pragma once

#include <algorithm>
#include <cstring>
#include <vector>

#include "arrays.hpp"

namespace motes::components {

using Bytes = Plane<const std::uint8_t>;

// Pixels from `begin` to before `end` in row y, which are connected to those of the run `parent`.
struct Run {
    Index y, begin, end;
    std::size_t parent;
};

// Returns where in a row a value, 0 or 1, comes next, or the row's end.
inline Index next(const std::uint8_t* row, Index from, Index width, int value) {
    const void* found = std::memchr(row + from, value, std::size_t(width - from));
    return found == nullptr ? width : static_cast<const std::uint8_t*>(found) - row;
}

// Returns the first run of the part that a run belongs to.
inline std::size_t first_of(std::vector<Run>& runs, std::size_t i) {
    while (runs[i].parent != i) i = runs[i].parent = runs[runs[i].parent].parent;
    return i;
}

// Returns the runs of a value from the top on, each with the first one of its part as parent.
//
// Runs in neighboring rows are connected where they share a column; with a `reach` of 1 also where
// their corners meet.
inline std::vector<Run> connected(Bytes mask, int value, Index reach) {
    std::vector<Run> runs;
    std::size_t here = 0;  // where the runs of a row begin
    for (Index y = 0; y < mask.rows; ++y) {
        std::size_t other = here;  // a run of the row above
        here = runs.size();
        for (Index begin = 0, end; begin < mask.columns; begin = end) {
            begin = next(mask[y], begin, mask.columns, value);
            if (begin == mask.columns) break;
            end = next(mask[y], begin, mask.columns, 1 - value);
            const std::size_t own = runs.size();
            runs.push_back({y, begin, end, own});
            while (other < here && runs[other].end + reach <= begin) ++other;
            for (std::size_t i = other; i < here && runs[i].begin < end + reach; ++i) {
                const std::size_t a = first_of(runs, i), b = first_of(runs, own);
                runs[std::max(a, b)].parent = std::min(a, b);
            }
        }
    }
    for (std::size_t i = 0; i < runs.size(); ++i) runs[i].parent = first_of(runs, i);
    return runs;
}

// Writes the number of each pixel's part, from 1 on, or 0; parts that meet at corners are one.
// Returns left, top, width, height and area of each part, in the order of their first pixels.
inline ScratchPlane<Index> label(Bytes mask, Plane<std::int32_t> labels) {
    fit(same_size(mask, labels), "labels of the mask's size");
    const std::vector<Run> runs = connected(mask, 1, 1);
    std::vector<Index> numbers(runs.size());
    Index count = 0;
    for (std::size_t i = 0; i < runs.size(); ++i)
        numbers[i] = runs[i].parent == i ? count++ : numbers[runs[i].parent];
    ScratchPlane<Index> parts(count, 5);
    std::fill_n(labels.data, mask.rows * mask.columns, 0);
    for (std::size_t i = 0; i < runs.size(); ++i) {
        const Run& run = runs[i];
        Index* part = parts[numbers[i]];  // right and bottom in place of width and height, at first
        if (run.parent == i) {
            part[0] = run.begin, part[1] = run.y, part[2] = run.end, part[4] = 0;
        }
        part[0] = std::min(part[0], run.begin), part[2] = std::max(part[2], run.end);
        part[3] = run.y + 1;
        part[4] += run.end - run.begin;
        std::fill(labels[run.y] + run.begin, labels[run.y] + run.end, std::int32_t(numbers[i] + 1));
    }
    for (Index i = 0; i < count; ++i) parts[i][2] -= parts[i][0], parts[i][3] -= parts[i][1];
    return parts;
}

// Adds to a mask the pixels of the one before that lie in the holes of an outline: connected parts
// of its zeros that do not reach the border.
inline void fill_holes(Bytes outline, Bytes before, Plane<std::uint8_t> mask) {
    fit(same_size(mask, outline, before), "three masks of one size");
    const std::vector<Run> runs = connected(outline, 0, 0);
    std::vector<bool> open(runs.size());
    for (const Run& run : runs)
        if (run.y == 0 || run.y == mask.rows - 1 || run.begin == 0 || run.end == mask.columns)
            open[run.parent] = true;
    for (const Run& run : runs)
        if (!open[run.parent])
            for (Index x = run.begin; x < run.end; ++x) mask[run.y][x] |= before[run.y][x];
}

}  // namespace motes::components
