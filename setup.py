"""How the kernels are compiled; all else about the package is in pyproject.toml."""

from __future__ import annotations

import os
import platform
import sys
from pathlib import Path

import numpy as np
from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext
from setuptools.errors import CCompilerError

KERNELS = Path("src", "motes", "kernels")
RANDOM = Path(np.random.__file__).with_name("lib")
"""Where numpy has `npyrandom`, its random numbers for C."""
UNIX = [
    "-std=c++17",
    "-O3",
    "-g0",
    "-fvisibility=hidden",
    # Results are the same bits on every processor; the last two only let loops become vector code.
    "-ffp-contract=off",
    "-fno-math-errno",
    "-fno-trapping-math",
]
WINDOWS = ["/std:c++17", "/O2", "/EHsc", "/fp:precise", "/utf-8"]
AVX2 = platform.machine().lower() in ("x86_64", "amd64") and sys.platform != "darwin"
"""Whether a second set is compiled. Macs with Intel's processors keep to the first."""


NO_COMPILER = """\
motes' kernels are C++17, and no compiler was found or it failed (see above). Install one: on Debian
and Ubuntu `apt install g++ python3-dev`, on macOS `xcode-select --install`, on Windows the "Build
Tools for Visual Studio". Or install a wheel, which needs none: `pip install motes`."""


class Build(build_ext):
    """Compiles with the flags that the compiler understands, all extensions at once."""

    def initialize_options(self) -> None:
        """Take all cores."""
        super().initialize_options()
        self.parallel = os.cpu_count()

    def build_extension(self, extension: Extension) -> None:
        """Compile one extension."""
        windows = self.compiler.compiler_type == "msvc"
        more = os.environ.get("MOTES_KERNEL_FLAGS", "").split()  # `make sanitize` has them
        extension.extra_compile_args = [*(WINDOWS if windows else UNIX), *more]
        if extension.name.endswith("_avx2"):
            extension.extra_compile_args.append("/arch:AVX2" if windows else "-mavx2")
        try:
            super().build_extension(extension)
        except (CCompilerError, OSError) as error:
            raise SystemExit(f"{error}\n{NO_COMPILER}") from error


def extension(name: str) -> Extension:
    """Return the extension whose source has a name."""
    return Extension(
        f"motes.kernels._{name}",
        [str(KERNELS / f"{name}.cpp")],
        depends=["setup.py", *map(str, sorted(KERNELS.glob("*.hpp")))],
        include_dirs=[np.get_include()],
        library_dirs=[str(RANDOM)],
        libraries=["npyrandom"],
        py_limited_api=True,
    )


setup(
    ext_modules=[extension("baseline"), *([extension("avx2")] if AVX2 else [])],
    cmdclass={"build_ext": Build},
    options={"bdist_wheel": {"py_limited_api": "cp311"}},
)
