"""DSP blocks of the core in any configuration, without a whole synthesis.

The RTL is elaborated by slang and taken through the first part of yosys's flow for the 7 series, up to the
step that packs multipliers into DSP48E1; what follows neither makes nor removes any. So the counts are those
of `make fpga-report`, in a fraction of its time. They are kept in build/bench/dsps/ by the hash of the RTL.
"""

import json
import subprocess
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from triaxis.coverage.whole_files import write_whole
from triaxis.fpga.report import CORE
from triaxis.fpga.synthesis import yosys, yosys_version
from triaxis.golden.errors import InputError
from triaxis.verif.build import content_hash, core_files
from triaxis.verif.configuration import Configuration
from triaxis.verif.paths import BUILD, DUT, rtl_sources

FOLDER = BUILD / "bench" / "dsps"
_JOBS = 2


def dsp_counts(
    configurations: Sequence[Configuration], progress: Callable[[int], None] | None = None
) -> list[int]:
    """Return the number of DSP48E1 of each configuration; ``progress`` is told of each.

    Raises InputError where the synthesiser is not installed or fails.
    """
    report = progress or (lambda _: None)
    tool = yosys_version()

    def count(configuration: Configuration) -> int:
        found = _count(configuration, tool)
        report(1)
        return found

    with ThreadPoolExecutor(_JOBS) as pool:
        return list(pool.map(count, configurations))


def _script(configuration: Configuration, statistics: Path) -> str:
    options = " ".join(f"-G {name}={value}" for name, value in configuration.parameters.items())
    files = " ".join(str(source) for source in rtl_sources() if source.name != "CollisionDetector.sv")
    return "; ".join(
        [
            # One thread: WebAssembly has no more.
            f"read_slang --threads 1 -I {DUT} {options} --top {CORE} {files}",
            f"synth_xilinx -family xc7 -flatten -noiopad -top {CORE} -run begin:coarse",
            f"tee -q -o {statistics} stat -json",
        ]
    )


def _count(configuration: Configuration, tool: str) -> int:
    name = configuration.name
    key = content_hash(
        core_files(), tool, _script(configuration, Path("statistics")).replace(str(DUT), "dut")
    )
    kept = FOLDER / f"{name}-{key[:12]}.json"
    try:
        return int(json.loads(kept.read_text(encoding="utf-8"))["DSP48E1"])
    except (OSError, ValueError, TypeError, KeyError):
        found = _elaborated(configuration, kept.with_suffix(".statistics"))
    write_whole(kept, json.dumps({"core": name, "DSP48E1": found, "tool": tool}) + "\n")
    return found


def _elaborated(configuration: Configuration, statistics: Path) -> int:
    statistics.parent.mkdir(parents=True, exist_ok=True)
    statistics.unlink(missing_ok=True)
    command = [str(yosys()), "-q", "-p", _script(configuration, statistics)]
    answer = subprocess.run(command, capture_output=True, text=True, check=False)
    if answer.returncode or not statistics.exists():
        lines = (answer.stdout + answer.stderr).splitlines()
        reason = next((line for line in lines if "ERROR" in line), f"exit status {answer.returncode}")
        raise InputError(f"yosys: {configuration.name}: {reason}")
    cells = json.loads(statistics.read_text(encoding="utf-8"))["design"]["num_cells_by_type"]
    statistics.unlink()
    return int(cells.get("DSP48E1", 0))
