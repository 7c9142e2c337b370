"""The compiled extensions: what Python may call, what they refuse, and that all give the same."""

import ast
import importlib
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motes import kernels
from motes.cues.gradients import DERIVATIVE, SMOOTH
from motes.cues.sampling import sunflower
from motes.cues.search_window import sectors
from motes.kernels.structures import (
    ColorBins,
    ColorTarget,
    LightLimits,
    MixtureLearning,
    PixelGrid,
    PointCues,
    Reading,
)
from oracles import mosaic

FOLDER = Path(kernels.__file__).parent
STUBS = sorted({*FOLDER.glob("*.pyi")} - {FOLDER / "__init__.pyi"})
PIXELS = mosaic(0, 60, 80)
ELLIPSES = np.array([[40.0, 30, 9, 14, 0.3], [3, 2, 8, 5, 1.0], [79, 59, 20, 20, 0]])
LATTICE = Reading(sunflower(100), PixelGrid(1, 1), kernels.sampling.GAUSSIAN)
SLOTS = np.arange(512, dtype=np.uint32)


def extension(name: str) -> Any:
    return importlib.import_module(f"motes.kernels._{name}")


@pytest.mark.parametrize("stub", STUBS, ids=[stub.stem for stub in STUBS])
def test_a_stub_has_what_the_extension_has(stub: Path) -> None:
    """Functions with the number of their arguments, and constants."""
    module = getattr(kernels, stub.stem)
    nodes = ast.parse(stub.read_text(encoding="utf-8")).body
    functions = {node.name: node for node in nodes if isinstance(node, ast.FunctionDef)}
    numbers = {node.target.id for node in nodes if isinstance(node, ast.AnnAssign)}  # type: ignore[union-attr]
    assert {*functions, *numbers} == {name for name in vars(module) if not name.startswith("__")}
    for name, node in functions.items():
        count = len(node.args.args)
        with pytest.raises(TypeError, match=f"^{name} takes {count} arguments, not {count + 1}$"):
            getattr(module, name)(*[None] * (count + 1))


def test_the_stub_of_all_lists_what_the_extension_has() -> None:
    listed, *_ = ast.parse((FOLDER / "__init__.pyi").read_text(encoding="utf-8")).body[1:]
    assert isinstance(listed, ast.ImportFrom)
    names = [each.name for each in listed.names]
    assert names == [stub.stem for stub in STUBS]
    assert {"INSTRUCTIONS", *names} == {*kernels.__all__} - {"has_avx2"}


def calls(compiled: Any) -> dict[str, Any]:
    """Return what kernels of an extension compute; those with most vector code."""
    found: dict[str, Any] = {}
    for space in (kernels.color.RGB, kernels.color.HSV, kernels.color.HSV_V):
        bins = ColorBins(space, 8, 8, 8)
        out = found[f"color {space}"] = np.empty((len(ELLIPSES), 512))
        slots = SLOTS[:72] if space == kernels.color.HSV_V else SLOTS
        compiled.color.histograms(PIXELS, ELLIPSES, LATTICE, slots, bins, out)
        roots = np.sqrt(out[0][:37])
        distances = found[f"distances {space}"] = np.empty(len(ELLIPSES))
        target = ColorTarget(LATTICE, slots % 38, roots, bins)
        compiled.color.distances(PIXELS, ELLIPSES, target, distances)
    edges = found["sobel"] = np.empty((60, 80), np.uint8)
    compiled.sobel.sobel(PIXELS, 0, 0, 100.0, 8, edges)
    certainty, orientation = np.empty((60, 80), np.float32), np.empty((60, 80), np.uint8)
    compiled.structure_tensor.structure_tensor(
        PIXELS, 0, 0, 1, SMOOTH, DERIVATIVE, SMOOTH, certainty, orientation, 18
    )
    found["certainty"], found["orientation"] = certainty, orientation
    hog = found["hog"] = np.empty((len(ELLIPSES), 72))
    compiled.hog.histograms_at(
        PIXELS, ELLIPSES, LATTICE.lattice, LATTICE.profile, 3, True, SMOOTH, DERIVATIVE, hog
    )
    samples = found["cut"] = np.empty((3, 24, 32), np.float32)
    compiled.search_window.cut(PIXELS, (3.0, 4.0), (1.7, 0.0), (0.0, 0.6), samples)
    cells = found["cells"] = np.empty((30, 6, 8), np.float32)
    compiled.search_window.gradient_cells(samples, sectors(), cells)
    posterior = found["posterior"] = np.empty((25, 33))
    inside, outside = samples.ravel()[:2048].repeat(16), np.ones(32768, np.float32)
    compiled.color_posterior.color_integral(samples, inside, outside, posterior)
    texture = found["texture"] = np.empty_like(samples)
    compiled.color_posterior.texture(samples[1], texture)
    cues = PointCues(samples[0], 1.0, posterior, (3.0, 2.0), 0.4, 5.0, (9.0, 9.0))
    normal, few = np.linspace(-2, 2, 300).reshape(3, 50, 2), np.full(51, 40)
    found["drawn"] = compiled.localization.draw(
        cues, normal, np.full(4, 0.3), (4.0, 6.0), 2.0, 1.0, few
    )
    spectra = (samples[:2] + 1j * samples[1:]).reshape(2, -1).astype(np.complex64)
    learned, power = np.zeros_like(spectra), np.ones(spectra.shape[1], np.float32)
    compiled.fourier_ridge.teach(spectra, spectra[0], 0.3, learned, power)
    response = found["response"] = np.empty_like(spectra[0])
    compiled.fourier_ridge.correlate(learned, power, spectra, response)
    transform = found["transform"] = np.empty((3, 24, 17), np.complex64)
    compiled.fourier.rfft2(samples, transform)
    back = found["back"] = np.empty_like(samples)
    compiled.fourier.irfft2(transform, back)
    square = found["square"] = np.empty((3, 31, 31), np.float32)
    compiled.network_input.read_square(PIXELS, -9, 20, 50, np.array([9.0, 99.0, 4.4]), square)
    mean = found["mean color"] = np.empty(3)
    compiled.network_input.mean_color(PIXELS, mean)
    relit = found["relit"] = np.empty(PIXELS.shape, np.uint8)
    compiled.planes.relight(PIXELS, 1.3, relit)
    planes, sums = np.moveaxis(PIXELS, 2, 0).copy(), np.empty((3, 60, 80), np.uint16)
    compiled.planes.window_sums(planes, sums)
    modes, numbers = compiled.mixture.MODES, compiled.mixture.FIELDS * compiled.mixture.PART
    model = found["mixture"] = np.zeros((modes, 3 * 60, numbers), np.float32)
    for shift in (0, 1, 0, 2):
        how = MixtureLearning(0.3, 0.05, 9.0, 15.0, 4.0, 75.0)
        compiled.mixture.learn(model, np.roll(planes, shift, axis=2), how)
    mask, lit = np.empty((2, 60, 80), np.uint8)
    compiled.mixture.foreground(model, np.roll(planes, 7, axis=1), 0.9, 16.0, mask)
    limits = LightLimits(0.5, 1.25, 12.0, 20.0)
    compiled.illumination.without_light(mask, sums, sums[:, ::-1].copy(), limits, lit)
    found["mask"], found["light"] = mask, lit
    return found


def test_all_processors_compute_the_same_bits() -> None:
    if not extension("baseline").has_avx2():
        pytest.skip("only one extension is of use here")
    one, other = calls(extension("baseline")), calls(extension("avx2"))
    for name, values in one.items():
        np.testing.assert_array_equal(other[name], values, err_msg=name, strict=True)
        assert np.ptp(np.abs(values)) > 0, name


LOCKED = np.ones((3, 512))
LOCKED.setflags(write=False)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("place", "value", "needed"),
    [
        (1, PIXELS[:, :, :2].copy(), "a picture, height x width x 3"),
        (1, PIXELS[:, ::-1], "a picture that as_rgb returns"),
        (1, PIXELS.astype(np.int8), "an array of uint8 with 3 axes in C order"),
        (2, ELLIPSES[0], "an array of float64 with 2 axes in C order"),
        (2, ELLIPSES.astype(">f8"), "an array of float64 with 2 axes in C order"),
        (2, ELLIPSES[:, ::-1], "a table whose rows lie in one piece each"),
        (3, LATTICE[:2], "a tuple of 3"),
        (3, (*LATTICE[:2], "gaussian"), "an integer"),
        (4, SLOTS[::2], "an array of uint32 with 1 axis in C order"),
        (5, (0, 8, 8), "a tuple of 4"),
        (6, LOCKED, "an array of float64 with 2 axes in C order, to be written"),
    ],
)
def test_what_a_kernel_cannot_read_is_refused(place: int, value: Any, needed: str) -> None:
    out, bins = np.empty((len(ELLIPSES), len(SLOTS))), ColorBins(0, 8, 8, 8)
    arguments: list[Any] = [PIXELS, ELLIPSES, LATTICE, SLOTS, bins, out]
    kernels.color.histograms(*arguments)
    arguments[place - 1] = value
    with pytest.raises(TypeError) as refused:
        kernels.color.histograms(*arguments)
    assert str(refused.value) == f"argument {place} of histograms must be {needed}"


def test_first_columns_of_a_table_are_read_in_place() -> None:
    wide = np.hstack([ELLIPSES, np.full((3, 4), np.nan)])
    assert kernels.sampling.bounds(wide[:, :5]) == kernels.sampling.bounds(ELLIPSES)


@pytest.mark.slow
def test_an_installation_without_kernels_says_what_to_do() -> None:
    code = (
        "import sys; sys.modules['motes.kernels._baseline'] = None\n"
        "from motes.cli import main; sys.exit(main(['doctor']))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 1
    (line,) = (line for line in done.stdout.splitlines() if line.startswith("kernels"))
    assert "motes' kernels are not compiled (" in line
    assert "run `pip install --editable .` where its sources are" in line


def test_a_step_draws_from_a_bit_generator_alone() -> None:
    pixels, states = np.zeros((9, 9, 3), np.uint8), np.zeros((1, 5))
    arguments: Any = (pixels, states, np.ones(1), np.random.PCG64(0))
    with pytest.raises(TypeError) as refused:
        kernels.color_filter.step(*arguments, *[None] * 5)
    assert str(refused.value) == "argument 4 of step must be the capsule of a bit generator"
