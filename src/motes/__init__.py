"""motes follows objects through video with particle filters.

Four more modules are public: `motes.cues` (how far pixels are from a target model),
`motes.filtering` (the interfaces of the parts of a tracker), `motes.synthetic` (rendered clips with
exact truth) and `motes.testing` (checks for packages that extend motes).
"""

__version__ = "0.1.0"


def __getattr__(name: str) -> object:
    """Load a public name when it is first used; `import motes` itself imports nothing."""
    from lazy_loader import attach_stub

    load, _, names = attach_stub(__name__, __file__)
    value: object = names if name == "__all__" else load(name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return [*__getattr__("__all__"), "__version__"]  # type: ignore[misc]
