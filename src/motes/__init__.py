"""motes follows objects through video with particle filters."""

__version__ = "0.1.0"
