"""Calls in a child of this process."""

import os
import signal
from collections.abc import Callable

from motes.core.errors import MotesError


def in_a_child(call: Callable[[], object]) -> str:
    """Return what a call returns, or how it is refused, in a child that lives for 20 s."""
    theirs, mine = os.pipe()
    if not (child := os.fork()):
        signal.alarm(20)
        try:
            said = str(call())
        except MotesError as error:
            said = str(error)
        os.write(mine, said.encode())
        os._exit(0)
    os.close(mine)
    with open(theirs, encoding="utf-8") as pipe:
        said = pipe.read()
    _, status = os.waitpid(child, 0)
    assert status == 0, "the child did not end"
    return said
