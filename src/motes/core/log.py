"""The logger `motes`: silent unless a program gives it, or the root logger, a handler."""

import logging

LOG = logging.getLogger("motes")
LOG.addHandler(logging.NullHandler())
