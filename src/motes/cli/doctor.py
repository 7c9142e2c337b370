"""`motes doctor`: a check of the installation."""

from __future__ import annotations

import importlib
import os
import platform
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path
from typing import NamedTuple

from motes import __version__
from motes.cli.exit_codes import DONE, FAULT
from motes.cli.explain import NO_HOME
from motes.core.callables import BROKEN, explain, is_missing

CORE = ("numpy", "scipy", "PIL", "msgspec", "rich")
OPTIONAL = {
    "cv2": "opencv",
    "dlib": "faces",
    "onnxruntime": "onnx",
    "matplotlib": "report",
    "pyarrow": "parquet",
    "motes_studio": "studio",
    "motes_fleet": "fleet",
    "motes_lab": "lab",
}
"""Optional modules, and the extras that install them."""
OPENCV = (
    "opencv-python",
    "opencv-python-headless",
    "opencv-contrib-python",
    "opencv-contrib-python-headless",
)


class Finding(NamedTuple):
    """A part of the installation, its state, and whether motes works with it."""

    what: str
    found: str
    good: bool = True


def doctor() -> int:
    """Check the installation: versions, codecs, compiled kernels, cores.

    The exit code is 0 if all parts work that are required or installed, else 1.
    """
    healthy = True
    for what, found, good in findings():
        print(f"{what:<16}{'' if good else 'PROBLEM: '}{found}")
        healthy &= good
    return DONE if healthy else FAULT


def findings() -> Iterator[Finding]:
    """Yield the state of each part of the installation."""
    yield Finding("motes", f"{__version__} in {Path(__file__).parents[1]}")
    yield Finding("python", f"{platform.python_version()} on {platform.platform()}")
    yield Finding("cores", str(os.cpu_count()))
    yield _kernels()
    for name in CORE:
        yield _module(name)
    yield from _video()
    for name, extra in OPTIONAL.items():
        yield _module(name, extra)
    yield from _networks()
    yield from _opencv_wheels()


def _module(name: str, extra: str | None = None) -> Finding:
    """Look for a module, which an extra installs or motes itself."""
    try:
        module = importlib.import_module(name)
    except Exception as error:  # an import may raise anything
        if extra is None:
            return Finding(name, f"{error}; install motes anew", good=False)
        if is_missing(error, name):
            return Finding(name, f"not installed (optional): pip install 'motes[{extra}]'")
        return Finding(name, BROKEN.format(explain(error)), good=False)
    return Finding(name, str(getattr(module, "__version__", "installed")))


def _video() -> Iterator[Finding]:
    finding = _module("av")
    yield finding
    if not finding.good:
        return
    import av

    for library, version in sorted(av.library_versions.items()):
        yield Finding(f"  {library}", ".".join(map(str, version)))
    for codec, mode, use in (("h264", "r", "reading"), ("libx264", "w", "writing")):
        try:
            av.Codec(codec, mode)  # type: ignore[arg-type]
        except (av.FFmpegError, ValueError) as error:
            yield Finding(f"H.264 {use}", f"{error}; install PyAV (av) anew", good=False)
        else:
            yield Finding(f"H.264 {use}", "works")


def _kernels() -> Finding:
    """Look for the compiled kernels, and which set of them this processor runs."""
    try:
        from motes import kernels
    except ImportError as error:
        return Finding("kernels", str(error), good=False)
    return Finding("kernels", f"compiled for {kernels.INSTRUCTIONS}")


def _networks() -> Iterator[Finding]:
    """Look for the trained networks that were downloaded."""
    from motes.sot.network.published import PUBLISHED, folder_of, is_whole

    for name in PUBLISHED:
        advice = f"motes network get {name}"
        try:
            folder = folder_of(name)
        except RuntimeError:
            yield Finding(name, f"not downloaded (optional): {NO_HOME}")
            continue
        if not folder.exists():
            yield Finding(name, f"not downloaded (optional): {advice}")
        elif is_whole(name):
            yield Finding(name, str(folder))
        else:
            yield Finding(name, f"files in {folder} are damaged; {advice}", good=False)


def _opencv_wheels() -> Iterator[Finding]:
    installed = []
    for wheel in OPENCV:
        try:
            installed.append(f"{wheel} {metadata.version(wheel)}")
        except metadata.PackageNotFoundError:
            continue
    if len(installed) > 1:
        yield Finding(
            "warning",
            f"{' and '.join(installed)} overwrite each other; uninstall all of them, then install "
            f"one",
        )
