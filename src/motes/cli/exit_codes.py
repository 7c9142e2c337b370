"""The exit codes of the commands; the help of each of them lists their meanings."""

DONE, FAULT, USAGE, UNREADABLE, NOT_FOUND, UNWRITABLE, PARTIAL, AWAY = range(8)
EXIT_CODES = """\
Exit codes:
  0    done
  1    a fault in motes or its installation
  2    wrong option, configuration or region, or a part is not installed
  3    an input cannot be read
  4    the target was never found
  5    an output exists or cannot be written
  6    done, but some sequences, trackers or cameras failed
  7    a live source ended, and was away for longer than --reconnect allows
  129  the terminal was closed (SIGHUP)
  130  interrupted by Ctrl-C (SIGINT)
  141  the reader of standard output has left, and there are other outputs
  143  terminated (SIGTERM)
With the last four, the outputs are finished and kept, and the summary is printed.
"""
NO_MEMORY = "There is not enough memory; use fewer particles or a smaller picture."
