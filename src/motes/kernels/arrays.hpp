// Arrays as kernels see them: the memory of numpy's, in C order; indices are not checked.
#pragma once

#include <cmath>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <memory>

namespace motes {

using Index = std::ptrdiff_t;

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
    operator T*() const { return values_.get(); }

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

private:
    Scratch<T> values_;
    Index rows_, columns_;
};

// An image, height x width x 3 bytes: red, green, blue.
struct Picture {
    const std::uint8_t* data;
    Index height, width;

    const std::uint8_t* row(Index y) const { return data + 3 * y * width; }
};

using Floats = Row<const double>;
using Taps = Row<const float>;         // of a filter, at 0 … r
using Ellipses = Table<const double>;  // rows x, y, a, b, theta
using Histograms = Plane<double>;      // a row for each ellipse
using Samples = Volume<const float>;   // channel, row, column
using Complex = std::complex<float>;

// Two values, of which the first may be across and the second down.
struct Pair {
    double x, y;
};

}  // namespace motes
