// The kernels for x86-64 processors since 2013, with vectors of 256 bits; the results are the same.
#include "module.hpp"

PyMODINIT_FUNC PyInit__avx2() {
    return motes::binding::extension("_avx2", "AVX2", nullptr);
}
