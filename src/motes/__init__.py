"""motes follows objects through video with particle filters.

Four more modules are public: `motes.cues` (how far pixels are from a target model),
`motes.filtering` (the parts of a particle filter), `motes.synthetic` (rendered clips with exact
truth) and `motes.testing` (checks for packages that extend motes).
"""

from lazy_loader import attach_stub

__version__ = "0.1.0"

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)
