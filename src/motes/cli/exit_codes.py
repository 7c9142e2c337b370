"""The exit codes of the commands; `motes --help` lists their meanings."""

DONE, FAULT, USAGE, UNREADABLE, NOT_FOUND, UNWRITABLE, PARTIAL, AWAY = range(8)
NO_MEMORY = "There is not enough memory; use fewer particles or a smaller picture."
