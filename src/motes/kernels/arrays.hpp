// Arrays as kernels see them: the memory of numpy's, in C order; indices are not checked.
//
// So a kernel asks whether sizes fit (`fit`), and makes an index only of a number that is limited
// (`limited`): whatever Python hands over, memory beside an array is neither read nor written.
#pragma once

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <memory>

namespace motes {

using Index = std::ptrdiff_t;

// Sizes of arrays do not fit together; `needed` is what would.
struct Misfit {
    const char* needed;
};

inline void fit(bool fits, const char* needed) {
    if (!fits) throw Misfit{needed};
}

// Returns whether planes, or the planes of volumes, have as many rows and columns as the first.
template <typename First, typename... Others>
bool same_size(const First& first, const Others&... others) {
    return ((others.rows == first.rows && others.columns == first.columns) && ...);
}

// Returns a value within 0 … most; 0 for NaN. It costs two operations of vector code.
template <typename T>
T limited(T value, T most) {
    return std::min(std::max(T(0), value), most);
}

// A row of values; of a `const` type, they are only read.
template <typename T>
struct Row {
    T* data;
    Index size;

    T& operator[](Index i) const { return data[i]; }
    T* begin() const { return data; }
    T* end() const { return data + size; }
};

// Values in rows and columns; plane[i][j] is one of them.
template <typename T>
struct Plane {
    T* data;
    Index rows, columns;

    T* operator[](Index i) const { return data + i * columns; }
    Row<T> row(Index i) const { return {(*this)[i], columns}; }
    Row<T> flat() const { return {data, rows * columns}; }
};

// Rows of a table, which may lie apart: the first columns of a wider one; table[i][j] is a value.
template <typename T>
struct Table {
    T* data;
    Index rows, columns, step;  // from a row to the next

    T* operator[](Index i) const { return data + i * step; }
    Row<T> row(Index i) const { return {(*this)[i], columns}; }
};

// Planes of the same size; volume[k][i][j] is one value.
template <typename T>
struct Volume {
    T* data;
    Index planes, rows, columns;

    Plane<T> operator[](Index k) const { return {data + k * rows * columns, rows, columns}; }
};

// Room to work in, as a row; its values are not set.
template <typename T>
class Scratch {
public:
    explicit Scratch(Index size) : values_(new T[static_cast<std::size_t>(size)]), size_(size) {}
    operator Row<T>() const { return {values_.get(), size_}; }
    operator Row<const T>() const { return {values_.get(), size_}; }
    operator T*() const { return values_.get(); }
    T* begin() const { return values_.get(); }
    Index size() const { return size_; }

private:
    std::unique_ptr<T[]> values_;
    Index size_;
};

// Room to work in, as a plane.
template <typename T>
class ScratchPlane {
public:
    ScratchPlane(Index rows, Index columns)
        : values_(rows * columns), rows_(rows), columns_(columns) {}
    operator Plane<T>() const { return {values_, rows_, columns_}; }
    T* operator[](Index i) const { return values_ + i * columns_; }
    T* begin() const { return values_; }
    Index rows() const { return rows_; }
    Index columns() const { return columns_; }

private:
    Scratch<T> values_;
    Index rows_, columns_;
};

// In which order the bytes of a pixel lie in memory; a gray one has one for all channels.
enum class Order { RGB, BGR, GRAY };

// An image of height x width pixels, read where it lies: a part of a larger one, with alpha, BGR.
struct Picture {
    const std::uint8_t* data;  // the first byte of the first pixel, whichever channel it is
    Index height, width;
    Index line, pixel;  // bytes from a row, and from a pixel, to the next
    Order order;

    const std::uint8_t* row(Index y) const { return data + y * line; }
    // Bytes of `count` pixels in a row, without what may lie between the last one and the next.
    Index span(Index count) const { return pixel * (count - 1) + green() + green() + 1; }
    // Where in a pixel its channels are.
    Index red() const { return order == Order::BGR ? 2 : 0; }
    Index green() const { return order == Order::GRAY ? 0 : 1; }
    Index blue() const { return order == Order::RGB ? 2 : 0; }
};

using Floats = Row<const double>;
using Taps = Row<const float>;        // of a filter, at 0 … r
using Histograms = Plane<double>;     // a row for each ellipse
using Samples = Volume<const float>;  // channel, row, column
using Complex = std::complex<float>;

// Rows x, y, a, b, theta, and perhaps more.
struct Ellipses : Table<const double> {};

// Two values, of which the first may be across and the second down.
struct Pair {
    double x, y;
};

}  // namespace motes
