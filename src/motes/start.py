"""Where the programs begin: an interrupt while they are imported ends them without a traceback.

Nothing is imported here, as an import that is interrupted is not caught yet.
"""

INTERRUPTED = 130
"""The exit code after an interrupt: 128 plus the number of SIGINT."""


def main() -> int:
    """Run motes with the arguments of the process; return the exit code."""
    try:
        import atexit
        import gc

        atexit.register(gc.freeze)  # to look for garbage at the end takes a tenth of a short run
        from motes.cli import main

        return main()
    except KeyboardInterrupt:
        return INTERRUPTED
