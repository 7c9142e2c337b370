from motes.kernels.structures import Pair, Singles, Spectra

def correlate(numerator: Spectra, power: Singles, spectra: Spectra, out: Spectra) -> None: ...
def pad(learned: Spectra, first: Spectra, share: float, gain: float, out: Spectra) -> None: ...
def center(plane: Singles, out: Singles) -> None: ...
def teach(
    spectra: Spectra, label: Spectra, rate: float, numerator: Spectra, power: Singles
) -> None: ...
def solve(
    spectra: Spectra,
    label: Spectra,
    before: Spectra,
    copied: Spectra,
    multiplier: Spectra,
    penalty: float,
    inertia: float,
    out: Spectra,
) -> None: ...
def confine(
    learned: Spectra,
    penalty: float,
    wide: int,
    high: int,
    multiplier: Spectra,
    copied: Spectra,
) -> None: ...
def alternate(
    spectra: Spectra,
    label: Spectra,
    before: Spectra,
    inertia: float,
    penalties: Pair,
    rounds: int,
    wide: int,
    high: int,
    out: Spectra,
) -> None: ...
