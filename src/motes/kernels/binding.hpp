// Python calls C++: arguments are read by the types that a kernel declares.
//
// An argument costs some ten nanoseconds. An array must have the right type and number of axes and
// lie in memory in C order; it is never copied.
#pragma once

#ifndef Py_LIMITED_API
#define Py_LIMITED_API 0x030B0000  // one extension for Python 3.11 and all later versions
#endif
#define PY_SSIZE_T_CLEAN
#define NPY_NO_DEPRECATED_API NPY_2_0_API_VERSION
#define NPY_TARGET_VERSION NPY_2_0_API_VERSION
#include <Python.h>
#include <numpy/arrayobject.h>
#include <numpy/random/bitgen.h>

#include <array>
#include <new>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "arrays.hpp"

namespace motes::binding {

// An argument has the wrong type or shape; `needed` is the right one.
struct Refused {
    std::string needed;
};

// What numpy calls a type: its kind.
template <typename T>
constexpr char kind() {
    if (std::is_same_v<T, Complex>) return 'c';
    if (std::is_floating_point_v<T>) return 'f';
    return std::is_signed_v<T> ? 'i' : 'u';
}

// Returns an array with axes of a type, with the flags of numpy's that it must have.
inline PyArrayObject* typed(PyObject* object, int axes, char kind, npy_intp size, int flags) {
    auto* array = reinterpret_cast<PyArrayObject*>(object);
    const bool fits = PyArray_Check(object) && PyArray_NDIM(array) == axes &&
                      PyArray_DESCR(array)->kind == kind && PyArray_ITEMSIZE(array) == size &&
                      PyArray_CHKFLAGS(array, flags | NPY_ARRAY_ALIGNED) &&
                      PyArray_ISNOTSWAPPED(array);
    if (fits) return array;
    const char* type = kind == 'c'   ? "complex"
                       : kind == 'f' ? "float"
                       : kind == 'i' ? "int"
                                     : "uint";
    throw Refused{std::string("an array of ") + type + std::to_string(8 * size) + " with " +
                  std::to_string(axes) + (axes == 1 ? " axis" : " axes") + " in C order" +
                  (flags & NPY_ARRAY_WRITEABLE ? ", to be written" : "")};
}

template <typename T, int N>
PyArrayObject* typed(PyObject* object, int flags) {
    if (!std::is_const_v<T>) flags |= NPY_ARRAY_WRITEABLE;
    return typed(object, N, kind<std::remove_const_t<T>>(), sizeof(T), flags);
}

// Reads the memory and shape of an array with N axes.
template <typename T, int N>
std::pair<T*, const npy_intp*> memory_of(PyObject* object) {
    PyArrayObject* array = typed<T, N>(object, NPY_ARRAY_C_CONTIGUOUS);
    return {static_cast<T*>(PyArray_DATA(array)), PyArray_DIMS(array)};
}

// Reads an argument of a kernel from a Python object.
template <typename T, typename = void>
struct Reader;

template <typename T>
struct Reader<Row<T>> {
    static Row<T> read(PyObject* object) {
        const auto [data, shape] = memory_of<T, 1>(object);
        return {data, shape[0]};
    }
};

template <typename T>
struct Reader<Plane<T>> {
    static Plane<T> read(PyObject* object) {
        const auto [data, shape] = memory_of<T, 2>(object);
        return {data, shape[0], shape[1]};
    }
};

template <typename T>
struct Reader<Table<T>> {
    static Table<T> read(PyObject* object) {
        PyArrayObject* array = typed<T, 2>(object, 0);
        constexpr auto size = npy_intp(sizeof(T));
        const npy_intp *shape = PyArray_DIMS(array), *strides = PyArray_STRIDES(array);
        const bool empty = shape[0] == 0 || shape[1] == 0;  // whose strides mean nothing
        if (!empty && (strides[0] % size != 0 || (strides[1] != size && shape[1] > 1)))
            throw Refused{"a table whose rows lie in one piece each"};
        return {static_cast<T*>(PyArray_DATA(array)), shape[0], shape[1], strides[0] / size};
    }
};

template <>
struct Reader<Ellipses> {
    static Ellipses read(PyObject* object) {
        const Table<const double> table = Reader<Table<const double>>::read(object);
        if (table.columns < 5) throw Refused{"ellipses, rows of x, y, a, b, theta"};
        return {table};
    }
};

template <typename T>
struct Reader<Volume<T>> {
    static Volume<T> read(PyObject* object) {
        const auto [data, shape] = memory_of<T, 3>(object);
        return {data, shape[0], shape[1], shape[2]};
    }
};

template <>
struct Reader<Picture> {
    static Picture read(PyObject* object) {
        PyArrayObject* array = typed<const std::uint8_t, 3>(object, 0);
        const npy_intp *shape = PyArray_DIMS(array), *strides = PyArray_STRIDES(array);
        const Index height = shape[0], width = shape[1];
        if (shape[2] != 3) throw Refused{"a picture, height x width x 3"};
        const auto* data = static_cast<const std::uint8_t*>(PyArray_DATA(array));
        // Strides of an axis of length 1 may be anything.
        if (PyArray_CHKFLAGS(array, NPY_ARRAY_C_CONTIGUOUS))
            return {data, height, width, 3 * width, 3, Order::RGB};
        const Index line = strides[0], pixel = strides[1], channel = strides[2];
        const auto order = channel == 1 ? Order::RGB : channel == 0 ? Order::GRAY : Order::BGR;
        const Picture view{channel < 0 ? data - 2 : data, height, width, line, pixel, order};
        if (channel < -1 || channel > 1 || pixel < view.span(1) || line < view.span(width) ||
            line > LARGEST_VIEW / height)
            throw Refused{"a picture that as_rgb returns"};
        return view;
    }

private:
    static constexpr Index LARGEST_VIEW = 2147483647;  // bytes: places in it have 32 bits
};

template <typename T>
struct Reader<T, std::enable_if_t<std::is_integral_v<T>>> {
    static T read(PyObject* object) {
        const long long value = PyLong_AsLongLong(object);
        if (value == -1 && PyErr_Occurred()) throw Refused{"an integer"};
        return static_cast<T>(value);
    }
};

template <>
struct Reader<double> {
    static double read(PyObject* object) {
        const double value = PyFloat_AsDouble(object);
        if (value == -1.0 && PyErr_Occurred()) throw Refused{"a number"};
        return value;
    }
};

// Reads the items of a tuple as the fields of a structure.
template <typename Structure, typename... Fields>
struct TupleReader {
    static Structure read(PyObject* object) {
        if (!PyTuple_Check(object) || PyTuple_Size(object) != sizeof...(Fields))
            throw Refused{"a tuple of " + std::to_string(sizeof...(Fields))};
        return items(object, std::index_sequence_for<Fields...>());
    }

private:
    template <std::size_t... I>
    static Structure items(PyObject* object, std::index_sequence<I...>) {
        return {Reader<Fields>::read(PyTuple_GetItem(object, I))...};
    }
};

template <>
struct Reader<bitgen_t*> {
    static bitgen_t* read(PyObject* object) {
        void* random = PyCapsule_GetPointer(object, "BitGenerator");
        if (random == nullptr) throw Refused{"the capsule of a bit generator"};
        return static_cast<bitgen_t*>(random);
    }
};

template <>
struct Reader<Pair> : TupleReader<Pair, double, double> {};

// Makes a Python object of what a kernel returns.
inline PyObject* object_of(bool value) {
    return PyBool_FromLong(value);
}
inline PyObject* object_of(Index value) {
    return PyLong_FromSsize_t(value);
}
inline PyObject* object_of(double value) {
    return PyFloat_FromDouble(value);
}

inline PyObject* object_of(const std::vector<float>& values) {
    npy_intp size = npy_intp(values.size());
    PyObject* array = PyArray_SimpleNew(1, &size, NPY_FLOAT32);
    if (array != nullptr)
        std::copy(values.begin(), values.end(),
                  static_cast<float*>(PyArray_DATA(reinterpret_cast<PyArrayObject*>(array))));
    return array;
}

// Makes an array of values that a kernel has found.
template <typename T>
PyObject* array_of(const T* values, int axes, const npy_intp* shape) {
    static_assert(std::is_same_v<T, double> || std::is_same_v<T, Index>);
    const int type = std::is_same_v<T, double> ? NPY_DOUBLE : NPY_INTP;
    PyObject* array = PyArray_SimpleNew(axes, shape, type);
    if (array != nullptr) {
        auto* made = reinterpret_cast<PyArrayObject*>(array);
        std::copy_n(values, PyArray_SIZE(made), static_cast<T*>(PyArray_DATA(made)));
    }
    return array;
}
template <typename T>
PyObject* object_of(const Scratch<T>& values) {
    const npy_intp shape[] = {npy_intp(values.size())};
    return array_of(values.begin(), 1, shape);
}
template <typename T>
PyObject* object_of(const ScratchPlane<T>& values) {
    const npy_intp shape[] = {npy_intp(values.rows()), npy_intp(values.columns())};
    return array_of(values.begin(), 2, shape);
}

template <std::size_t N>
PyObject* object_of(const std::array<double, N>& values);
template <typename... Values>
PyObject* object_of(const std::tuple<Values...>& values);

template <typename... Values>
PyObject* tuple_of(const Values&... values) {
    const std::array<PyObject*, sizeof...(Values)> items{object_of(values)...};
    PyObject* tuple = PyTuple_New(Py_ssize_t(items.size()));
    for (std::size_t i = 0; i < items.size(); ++i)  // the tuple takes the references
        PyTuple_SetItem(tuple, Py_ssize_t(i), items[i]);
    return tuple;
}

template <typename... Values>
PyObject* object_of(const std::tuple<Values...>& values) {
    return std::apply([](const auto&... each) { return tuple_of(each...); }, values);
}

template <std::size_t N>
PyObject* object_of(const std::array<double, N>& values) {
    return std::apply([](auto... each) { return tuple_of(each...); }, values);
}

// Gives the interpreter's lock away while it lives, if `gives`.
template <bool gives>
class Unlocked {
public:
    Unlocked() : state_(gives ? PyEval_SaveThread() : nullptr) {}
    ~Unlocked() {
        if (gives) PyEval_RestoreThread(state_);
    }

private:
    PyThreadState* state_;
};

// Makes a Python error of what was thrown while a kernel of a name was called. It is one function
// for all kernels, and not a part of each.
inline PyObject* failed(const char* name, std::size_t place) {
    try {
        throw;
    } catch (const Refused& refused) {
        PyErr_Clear();
        return PyErr_Format(PyExc_TypeError, "argument %zu of %s must be %s", place, name,
                            refused.needed.c_str());
    } catch (const Misfit& misfit) {
        return PyErr_Format(PyExc_ValueError, "%s needs %s", name, misfit.needed);
    } catch (const std::bad_alloc&) {
        return PyErr_NoMemory();
    }
}

// What Python calls for a kernel.
template <auto kernel, bool unlocked>
struct Call;

template <typename Result, typename... Arguments, Result (*kernel)(Arguments...), bool unlocked>
struct Call<kernel, unlocked> {
    static inline const char* name = "";

    static PyObject* call(PyObject*, PyObject* const* given, Py_ssize_t count) {
        constexpr Py_ssize_t wanted = sizeof...(Arguments);
        if (count != wanted)
            return PyErr_Format(PyExc_TypeError, "%s takes %zd arguments, not %zd", name, wanted,
                                count);
        std::size_t place = 0;
        try {
            return run(read(given, place, std::index_sequence_for<Arguments...>()));
        } catch (...) {
            return failed(name, place);
        }
    }

private:
    using Values = std::tuple<std::decay_t<Arguments>...>;

    // Reads the arguments from left to right; `place` is that of the last one read, from 1.
    template <std::size_t... I>
    static Values read(PyObject* const* given, std::size_t& place, std::index_sequence<I...>) {
        const auto reached = [&](std::size_t i) { return place = i + 1, given[i]; };
        return Values{Reader<std::decay_t<Arguments>>::read(reached(I))...};
    }

    static PyObject* run(const Values& arguments) {
        const auto apply = [&] {
            const Unlocked<unlocked> lock;
            return std::apply(kernel, arguments);
        };
        if constexpr (std::is_void_v<Result>) {
            apply();
            return Py_NewRef(Py_None);
        } else {
            return object_of(apply());
        }
    }
};

template <auto kernel, bool unlocked>
PyMethodDef method(const char* name) {
    using Called = Call<kernel, unlocked>;
    Called::name = name;
    auto* function = reinterpret_cast<PyCFunction>(reinterpret_cast<void (*)()>(&Called::call));
    return {name, function, METH_FASTCALL, nullptr};
}

// A kernel that runs without the interpreter's lock.
template <auto kernel>
PyMethodDef unlocked(const char* name) {
    return method<kernel, true>(name);
}

// A kernel of microseconds, for which giving the lock away and back would take longer.
template <auto kernel>
PyMethodDef brief(const char* name) {
    return method<kernel, false>(name);
}

// Adds a module of kernels and numbers to a package.
inline bool add(PyObject* package, const char* name, std::initializer_list<PyMethodDef> kernels,
                std::initializer_list<std::pair<const char*, long>> numbers = {}) {
    auto* kept = new std::vector<PyMethodDef>(kernels);  // as long as the process
    kept->push_back({nullptr, nullptr, 0, nullptr});
    PyObject* module = PyModule_New(name);
    if (module == nullptr || PyModule_AddFunctions(module, kept->data()) < 0) return false;
    for (const auto& [key, value] : numbers)
        if (PyModule_AddIntConstant(module, key, value) < 0) return false;
    return PyModule_AddObjectRef(package, name, module) == 0;
}

}  // namespace motes::binding
