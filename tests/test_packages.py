"""What others build and install motes by, which no test installs: recipes and workflows."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path
from typing import Any

import pytest
import yaml

from motes.cli.doctor import OPTIONAL

ROOT = Path(__file__).parents[1]
WORKFLOWS = sorted((ROOT / ".github/workflows").glob("*.yml"))


def project(folder: str) -> dict[str, Any]:
    """Return what the `pyproject.toml` of a folder says of its distribution."""
    found: dict[str, Any] = tomllib.loads((ROOT / folder / "pyproject.toml").read_text("utf-8"))
    return found["project"]  # type: ignore[no-any-return]


def steps(workflow: Path) -> list[dict[str, Any]]:
    jobs = yaml.safe_load(workflow.read_text("utf-8"))["jobs"]
    return [step for job in jobs.values() for step in job["steps"]]


def test_the_conda_recipe_asks_for_what_the_library_asks_for() -> None:
    recipe = yaml.safe_load((ROOT / "conda/recipe.yaml").read_text("utf-8"))
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text("utf-8"))
    library = project(".")
    assert recipe["package"] == {"name": "motes", "version": library["version"]}
    assert citation["version"] == library["version"]
    asked = [f"python{library['requires-python']}", *library["dependencies"]]
    assert [each.replace(" ", "") for each in recipe["requirements"]["run"]] == asked


def test_motes_doctor_looks_for_all_that_extras_install() -> None:
    extras = project(".")["optional-dependencies"].keys() - {"all", "docs", "dev"}
    assert set(OPTIONAL.values()) == extras


@pytest.mark.parametrize("workflow", WORKFLOWS, ids=lambda path: path.stem)
def test_actions_are_named_by_their_hashes(workflow: Path) -> None:
    used = [step["uses"] for step in steps(workflow) if "uses" in step]
    assert used
    assert all(re.fullmatch(r"[\w/-]+@[0-9a-f]{40}", each) for each in used)


def test_workflows_install_all_that_is_not_published_from_the_checkout() -> None:
    lines = [step["run"] for path in WORKFLOWS for step in steps(path) if "run" in step]
    found = 0
    for line in lines:
        given = re.findall(r"--editable \"?([\w./]+)(?:\[([\w,]+)\])?", line)
        wanted, here = set[str](), {project(folder)["name"] for folder, _ in given}
        for folder, extras in given:
            of = project(folder)
            extra = (of["optional-dependencies"][name] for name in extras.split(",") if name)
            wanted.update(*extra, of["dependencies"])
        found += bool(given)
        ours = {re.match(r"[\w-]+", each)[0] for each in wanted if each.startswith("motes")}  # type: ignore[index]
        assert ours <= here, line
    assert found == 2


def test_the_image_is_made_of_what_is_here() -> None:
    """Nothing here builds images: instructions are read, and what they name is looked up."""
    text = (ROOT / "Dockerfile").read_text("utf-8")
    ignored = (ROOT / ".dockerignore").read_text("utf-8").splitlines()
    code = re.sub(r"^#.*\n", "", text, flags=re.M).replace("\\\n", "")
    made = dict(re.findall(r"^([A-Z]+) (.+)", code, re.M))
    assert {*re.findall(r"^\S+", code, re.M)} == {*made} == {
        "ARG", "FROM", "RUN", "WORKDIR", "COPY", "USER", "ENTRYPOINT", "CMD"
    }  # fmt: skip
    assert {*re.findall(r"\$\{?(\w+)", code)} == {*re.findall(r"^ARG (\w+)=", code, re.M)}
    assert re.findall(r"from=(\w+)", code) == re.findall(r" AS (\w+)", code)
    folders = re.findall(r"--wheel-dir \S+ (.+)", code)[0].split()
    for folder in folders:
        for name in ("src", "pyproject.toml", "README.md"):
            assert (ROOT / folder / name).exists()
            assert f"!{Path(folder, name).parts[0]}" in ignored
    packages = {each["name"]: each for each in map(project, folders)}
    for page in ("Dockerfile", "docs/quickstart.md", "docs/examples/worker.Dockerfile"):
        ((name, added),) = re.findall(r"PACKAGES='(.+)\[(.+)\]'", (ROOT / page).read_text("utf-8"))
        assert {*added.split(",")} <= {*packages[name]["optional-dependencies"]}
    (program,) = json.loads(made["ENTRYPOINT"])
    assert program in project(".")["scripts"]
    assert json.loads(made["CMD"]) == ["--help"]
