"""The file of a lens, as `cv2.FileStorage` writes it."""

from collections.abc import Sequence


def lens_file(
    focal: float = 100.0,
    distortion: Sequence[float] = (-0.2, 0.0, 0.0, 0.0, 0.0),
    size: tuple[int, int] = (120, 90),
) -> str:
    """Return the text in YAML; the middle of the pictures is that of the lens."""
    width, height = size
    matrix = (focal, 0.0, width / 2, 0.0, focal, height / 2, 0.0, 0.0, 1.0)
    return (
        f"%YAML:1.0\n---\nimage_width: {width}\nimage_height: {height}\n"
        f"camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: "
        f"[ {', '.join(map(str, matrix))} ]\ndistortion_coefficients: !!opencv-matrix\n   rows: 1\n"
        f"   cols: {len(distortion)}\n   dt: d\n   data: [ {', '.join(map(str, distortion))} ]\n"
    )
