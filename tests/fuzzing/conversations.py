"""What a tracker in another program says over TraX."""

from __future__ import annotations

from pathlib import Path

from motes.core.errors import MotesError
from motes.core.geometry import Box
from motes_lab.adapters.trax import Program, parse

from .outcomes import READ, REFUSED, check_finite, check_message, put


def seeds() -> list[bytes]:
    """Return conversations of several versions."""
    hello = b'@@TRAX:hello "trax.version=%d" "trax.region=rectangle;polygon" "trax.image=path"\n'
    state = b'@@TRAX:state "120.5,80,60,4e1" "confidence=0.5"\n'
    return [
        hello % 1 + b"loaded\n" + state * 3 + b"@@TRAX:quit\n",
        hello % 4 + state + b'@@TRAX:state "1"\n' + b'@@TRAX:quit "trax.reason=no \\"more\\""\n',
        b"@@TRAX:hello\n@@TRAX:status 1,2,3,4\n",
    ]


def check(data: bytes) -> str:
    """Let a program say this: it is understood, or refused when it says what it should not."""
    for line in data.decode(errors="replace").splitlines():
        parse(line)
    found, program, image = REFUSED, None, Path("/nowhere.png")
    try:
        program = Program(["cat", str(put("talk", data))])
        check_finite(program.initialize(image, Box(1, 2, 3, 4)) or ())
        found = READ
        for _ in range(3):
            check_finite(program.frame(image) or ())
    except MotesError as error:
        check_message(str(error))
    finally:
        if program is not None:
            program.close()
    return found
