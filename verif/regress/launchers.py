"""Where runs go: this machine, a Slurm cluster, an LSF cluster."""

import contextlib
import getpass
import os
import shutil
import subprocess
from dataclasses import dataclass

from triaxis.golden.errors import InputError
from triaxis.sim.toolchain import verilator

LOCAL, SLURM, LSF = "local", "slurm", "lsf"
LAUNCHERS = (LOCAL, SLURM, LSF)

# What a run asks Slurm for, unless the environment says otherwise: a simulation and its checker take a core
# or two, and less than a gigabyte.
_SLURM_DEFAULTS = {
    "SLURM_MEM": "2G",
    "SLURM_MINCPUS": "1",
    "SLURM_CPUS_PER_TASK": "1",
    "SLURM_TIMEOUT": "600",
}
# Runs at a time on a cluster, whose scheduler queues what it has no place for.
_CLUSTER_JOBS = 64
# What a cluster's controller may take to answer.
_ANSWER_SECONDS = 300.0


@dataclass(frozen=True)
class Launcher:
    """Where runs go. ``job_name``: what a cluster's jobs are called, so that they can be ended together."""

    kind: str
    job_name: str
    jobs: int

    def environment(self) -> dict[str, str]:
        """Return the environment in which dvsim starts."""
        environment = dict(os.environ)
        # dvsim asks `verilator` for its version.
        environment["PATH"] = verilator().environment()["PATH"]
        # A make that called us hands down its own options.
        for name in ("MAKEFLAGS", "MFLAGS", "MAKELEVEL"):
            environment.pop(name, None)
        environment["DVSIM_BACKEND"] = SLURM if self.kind == SLURM else LOCAL
        if self.kind == SLURM:
            defaults = {**_SLURM_DEFAULTS, "SLURM_QUEUE": _default_partition()}
            environment = {**defaults, **environment, "SLURM_JOB_NAME": self.job_name}
        return environment

    @property
    def prefix(self) -> str:
        """Return what is put before each command.

        LSF goes this way, and dvsim keeps watch over the waiting `bsub`: its own LSF launcher does not fit
        its scheduler, and ends in an error before it has submitted anything (1.57).
        """
        return f"bsub -I -J {self.job_name}" if self.kind == LSF else ""

    def end_jobs(self) -> None:
        """End what is left on the cluster of this or of an earlier, killed regression of the same name."""
        commands = {
            SLURM: ["scancel", "--quiet", f"--user={getpass.getuser()}", f"--name={self.job_name}"],
            LSF: ["bkill", "-J", self.job_name, "0"],
        }
        if self.kind in commands:
            with contextlib.suppress(subprocess.TimeoutExpired):
                subprocess.run(commands[self.kind], capture_output=True, check=False, timeout=_ANSWER_SECONDS)


def launcher(kind: str, job_name: str, jobs: int | None) -> Launcher:
    """Return a launcher; raise InputError where its cluster does not answer. ``jobs``: None: what suits."""
    if kind == SLURM:
        _check_tool("srun", "Slurm's commands", "slurm-client")
        _default_partition()
    if kind == LSF:
        _check_tool("bsub", "LSF's commands", None)
    usual = max(1, os.cpu_count() or 1) if kind == LOCAL else _CLUSTER_JOBS
    return Launcher(kind, job_name, jobs or usual)


def _check_tool(name: str, what: str, package: str | None) -> None:
    if shutil.which(name) is None:
        hint = f" (Debian: apt-get install {package})" if package else ""
        raise InputError(f"{name}: not found: install {what}{hint}, or run with --launcher local")


def _default_partition() -> str:
    """Return Slurm's default partition, or the first; raise InputError where Slurm does not answer."""
    hint = "see verif/regress/slurm_node.sh for one node"
    command = ["sinfo", "--noheader", "--format=%P"]
    try:
        answer = subprocess.run(
            command, capture_output=True, text=True, check=False, timeout=_ANSWER_SECONDS
        )  # fmt: skip
    except subprocess.TimeoutExpired as error:
        raise InputError(f"Slurm does not answer: sinfo waits {_ANSWER_SECONDS:g} s; {hint}") from error
    names = answer.stdout.split()
    if answer.returncode or not names:
        reason = (answer.stderr.strip().splitlines() or ["no partition"])[0]
        raise InputError(f"Slurm does not answer: {reason}; {hint}")
    return next((name for name in names if name.endswith("*")), names[0]).rstrip("*")
