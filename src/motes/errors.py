"""The errors that motes raises; every message says what is wrong and what to do."""


class MotesError(Exception):
    """Base of all errors that motes raises on purpose."""


class SourceError(MotesError):
    """A video, image or stream cannot be read."""


class FormatError(MotesError):
    """A file that motes reads or writes for results has the wrong form."""


class ConfigError(MotesError, ValueError):
    """A configuration, an option or a region makes no sense."""


class LimitError(MotesError):
    """A stated limit was passed, or an optional part is not installed."""
