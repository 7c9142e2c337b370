"""Try an installation of motes: its kernels, the reports of `doctor`, and a short demo.

python .ci/try_installation.py
"""

from __future__ import annotations

import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path


def main() -> None:
    """Run what needs the kernels, away from the sources."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-c", "import motes.kernels; print(motes.kernels.__file__)"]
        found = subprocess.check_output(command, cwd=folder, text=True).strip()
        if not Path(found).is_relative_to(sysconfig.get_path("platlib")):
            sys.exit(f"This is not an installation, but {found}.")
        for arguments in (["doctor"], ["demo", "--out", "demo", "--frames", "40"]):
            motes = Path(sysconfig.get_path("scripts"), "motes")
            subprocess.run([str(motes), *arguments], cwd=folder, check=True)
        print("40 frames:", sorted(path.name for path in Path(folder, "demo").iterdir()))


if __name__ == "__main__":
    main()
