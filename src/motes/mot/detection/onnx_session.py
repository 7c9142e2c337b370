"""Models in ONNX files, opened by onnxruntime."""

from __future__ import annotations

import ast
from pathlib import Path
from typing import Any

from motes.core.errors import MissingDependencyError, SourceError
from motes.mot.detection.adapters import Names


def session_of(file: str, threads: int | None) -> Any:
    """Return a session of onnxruntime.

    Raises
    ------
    MissingDependencyError
        If onnxruntime is not installed.
    SourceError
        If the file cannot be read, or is no ONNX file.
    """
    try:
        import onnxruntime
    except ImportError:
        raise MissingDependencyError(
            "ONNX files need onnxruntime; install it with: pip install 'motes[onnx]'."
        ) from None
    if not Path(file).is_file():
        raise SourceError(f"There is no file {file}; check the name.")
    options = onnxruntime.SessionOptions()
    options.log_severity_level = 4  # its warnings are not for users
    if threads is not None:
        options.intra_op_num_threads = threads
    try:
        return onnxruntime.InferenceSession(file, options, providers=["CPUExecutionProvider"])
    except Exception as error:  # onnxruntime has errors of many kinds
        raise SourceError(f"{file} cannot be read as ONNX: {one_line(error)}") from None


def one_line(error: Exception) -> str:
    """Return an error of onnxruntime in one line."""
    return " ".join(str(error).split())[:200].rstrip(".") + "."


def named_classes(session: Any) -> Names:
    """Return the names of classes in the file's metadata, as Ultralytics writes them."""
    text = session.get_modelmeta().custom_metadata_map.get("names", "")
    try:
        names = ast.literal_eval(text)
    except (ValueError, SyntaxError):
        return ()
    if isinstance(names, dict):
        return {int(number): str(name) for number, name in names.items()}
    return [str(name) for name in names] if isinstance(names, list | tuple) else ()
