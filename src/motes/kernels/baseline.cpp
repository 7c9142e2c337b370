// The kernels for any processor.
#include "module.hpp"

#if defined(_MSC_VER)
#include <windows.h>
#endif

// Returns whether this processor and its system know the instructions of the other extension.
static PyObject* has_avx2(PyObject*, PyObject*) {
#if defined(_MSC_VER) && defined(_M_X64)
    return PyBool_FromLong(IsProcessorFeaturePresent(40 /* PF_AVX2_INSTRUCTIONS_AVAILABLE */));
#elif defined(__x86_64__)
    __builtin_cpu_init();
    return PyBool_FromLong(__builtin_cpu_supports("avx2"));
#else
    return PyBool_FromLong(0);
#endif
}

static PyMethodDef functions[] = {{"has_avx2", has_avx2, METH_NOARGS, nullptr},
                                  {nullptr, nullptr, 0, nullptr}};

PyMODINIT_FUNC PyInit__baseline() {
    return motes::binding::extension("_baseline", "any processor", functions);
}
