"""The errors that motes raises; every message says what is wrong and what to do."""


class MotesError(Exception):
    """Base of all errors that motes raises on purpose."""


class SourceError(MotesError):
    """A video, image or stream cannot be read."""


class FormatError(MotesError):
    """A file of results has the wrong form, exists already, or cannot be read or written."""


class ConfigError(MotesError, ValueError):
    """A configuration, an option or a region makes no sense."""


class LimitError(MotesError):
    """An optional part is not installed."""
