"""Numbers of a run for Prometheus, in its text format, version 0.0.4.

See https://prometheus.io/docs/instrumenting/exposition_formats.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal, NamedTuple

CONTENT_TYPE = "text/plain; version=0.0.4; charset=utf-8"


class Metric(NamedTuple):
    """A number, or several with labels.

    Attributes
    ----------
    name, kind, what
        Its name, whether it only grows, and what it is.
    values
        For the values of its labels, in the order of `labels`, a number.
    labels
        The names of its labels.
    """

    name: str
    kind: Literal["counter", "gauge"]
    what: str
    values: Mapping[tuple[str, ...], float]
    labels: tuple[str, ...] = ()


def text(metrics: list[Metric]) -> str:
    """Return metrics in the text format."""
    lines = []
    for metric in metrics:
        lines.append(f"# HELP {metric.name} {metric.what}")
        lines.append(f"# TYPE {metric.name} {metric.kind}")
        for values, number in metric.values.items():
            pairs = zip(metric.labels, values, strict=True)
            inner = ",".join(f'{label}="{_escaped(value)}"' for label, value in pairs)
            lines.append(f"{metric.name}{'{' + inner + '}' if inner else ''} {number:.15g}")
    return "".join(line + "\n" for line in lines)


def _escaped(value: str) -> str:
    return value.replace("\\", "\\\\").replace("\n", "\\n").replace('"', '\\"')
