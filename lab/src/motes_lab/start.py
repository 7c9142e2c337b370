"""Where the lab begins, as `motes.start`."""

from motes.start import INTERRUPTED


def main() -> int:
    """Run motes-lab with the arguments of the process; return the exit code."""
    try:
        from motes_lab.cli import main

        return main()
    except KeyboardInterrupt:
        return INTERRUPTED
