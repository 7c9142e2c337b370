"""Options of the command line: a line for each word of it, the command first."""

import contextlib
import io
import os
from functools import cache
from pathlib import Path

import numpy as np
from PIL import Image

from motes.cli import main
from motes.cli.exit_codes import DONE, FAULT, NOT_FOUND, PARTIAL
from motes_lab.cli import main as lab

from .outcomes import READ, REFUSED, DefectError, check_message, scratch

COMMANDS = ("track", "watch", "evaluate")


def seeds() -> list[bytes]:
    lines = (
        "track --init 10,12,20,16 --start 0 --end 4 --stride 1 --seed 3",
        "track --init 20,20,9,7.5,0.3 --preset nummiaro --set budget.max=500",
        "track --init 10,12,20,16 --init 30,20,9,9 --preset nummiaro",
        "track --preset nummiaro --set particles=80 --set color.bins=8,8,8 "
        "--set motion.noise.size=0.05 --set likelihood.sigma=0.1 --dump-config",
        "watch --line 1,2,30,40 --zone 1,1,50,1,50,40 --dwell 0.5 --scale 20 --seed 1 --end 3",
        "watch --like 10,12,20,16 --end 3",
        "watch --set initiation.min-hits=3 --set detector.history=200 --dump-config",
        "evaluate --seeds 2 --workers 1 --time-limit 60 --first-pixel 0",
    )
    return [line.replace(" ", "\n").encode() for line in lines]


def check(data: bytes) -> str:
    """Run a command: it ends in good order, or says in one line what is wrong."""
    command, *words = os.fsdecode(data.replace(b"\0", b"")).split("\n")
    if command not in COMMANDS:
        command = "track"
    measured = command == "evaluate"
    source = "missing" if measured else str(_pictures())
    output = ["--out" if measured else "-o", str(scratch() / "rows.csv"), "--overwrite"]
    said = io.StringIO()
    with contextlib.redirect_stderr(said), contextlib.redirect_stdout(io.StringIO()):
        code = (lab if measured else main)([command, source, *words, *output])
    errors = [line for line in said.getvalue().splitlines() if line.startswith("motes: error: ")]
    if code == FAULT or len(errors) != (code not in (DONE, PARTIAL)):
        raise DefectError(f"The command ended with {code}: {said.getvalue()}")
    for line in errors:
        check_message(line)
    return READ if code in (DONE, NOT_FOUND) else REFUSED


@cache
def _pictures() -> Path:
    folder = scratch() / "pictures"
    folder.mkdir()
    rng = np.random.default_rng(0)
    for index in range(4):
        pixels = rng.integers(0, 256, (48, 64, 3), np.uint8)
        Image.fromarray(pixels).save(folder / f"{index}.png")
    return folder
