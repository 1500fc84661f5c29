"""Each module of dut/, synthesised alone, proved equal to its RTL if that ends."""

import re
import shutil
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from triaxis.golden.errors import InputError
from triaxis.sim.paths import DUT, board_sources, mesh_sources, rtl_sources
from triaxis.sim.programs import read_slang, run_to_result, yosys
from triaxis.verif.formal.netlist import flat, run_yosys
from triaxis.verif.formal.proof import FAIL, Finding, Proof, run_sby
from triaxis.verif.netlist.gates import cells

_GOLD, _GATE, _CELLS = "gold.il", "gate.v", "cells_sim.v"
# Rounds in which names that mean something else in the netlist are given up as points to compare at.
_ROUNDS = 4


class Way(StrEnum):
    """How a module is proved equal to its netlist."""

    # For modules that forget: any two states, and all that they can do from then on.
    WINDOW = "complete window from arbitrary states"
    # Registers of one name hold the same: then outputs are the same, and the registers after a clock.
    REGISTERS = "induction over registers of the same name"


@dataclass(frozen=True)
class ModuleProof(Proof):
    """A module at some parameters. ``clocks``: of the window; or of the induction.

    ``settled``: bits of the RTL's registers that only ever take one value hold it from the start.
    """

    clocks: int
    settled: bool = False

    @property
    def top(self) -> str:
        """Return the module."""
        return self.name.partition("(")[0]

    def attempt(self, dut: Path, folder: Path) -> Finding:
        """Synthesise the module, and prove it; see `Proof`."""
        shutil.rmtree(folder, ignore_errors=True)
        self.synthesise(dut, folder)
        return self.compare(folder)

    def synthesise(self, dut: Path, folder: Path) -> None:
        """Write the module as it is and as cells into ``folder``, with the cells' models."""
        values = {key: int(value) for key, value in self.parameters.items()}
        sources = (*rtl_sources(), *mesh_sources(), *board_sources())
        names = [path.relative_to(DUT).as_posix() for path in sources]
        # Registers that are to be matched keep their names, and state machines their numbers.
        keep = (
            'setattr -set keep 1 w:*_q* w:*_o*; setattr -set fsm_encoding "none" w:*_q; '
            if self.method == Way.REGISTERS
            else ""
        )
        script = (
            f"{read_slang(flat(names), self.top, values)}; hierarchy -top {self.top}; "
            f"write_rtlil {_GOLD}; {keep}synth_xilinx -family xc7 -flatten -noiopad -top {self.top}; "
            f"rename {self.top} gate; write_verilog -noattr {_GATE}"
        )
        run_yosys(script, dut, names, folder, _GATE)
        shutil.copy(cells(), folder / _CELLS)

    def compare(self, folder: Path) -> Finding:
        """Prove what `synthesise` wrote equal."""
        return self._window(folder) if self.method == Way.WINDOW else self._registers(folder)

    def _window(self, folder: Path) -> Finding:
        (folder / "proof.sby").write_text(
            "\n".join(
                [
                    "[options]", "mode bmc", f"depth {self.clocks}", f"skip {self.clocks - 1}",
                    "[engines]", "smtbmc yices",
                    "[script]",
                    f"read_verilog {_GATE} {_CELLS}", "prep -flatten -top gate", "design -stash gate",
                    f"read_rtlil {_GOLD}", f"prep -flatten -top {self.top}", f"rename {self.top} gold",
                    "design -copy-from gate gate",
                    "async2sync", "setattr -unset init gate/w:* gold/w:*",
                    "miter -equiv -flatten -make_assert -make_outputs gold gate miter",
                    "prep -top miter", "memory_map", "setattr -unset init w:*", "opt -full",
                    "[files]", _GOLD, _GATE, _CELLS, "",
                ]
            ),
            encoding="utf-8",
        )  # fmt: skip
        log = folder / "prove.log"
        status = run_sby(folder, log)
        model = (folder / "proof" / "model" / "design_smt2.smt2").read_text(encoding="utf-8")
        facts = {"points": model.count("; yosys-smt2-assert")}
        wrong = status == FAIL or not facts["points"]
        return Finding((f"{self.name}: not equal to its netlist (log: {log})",) if wrong else (), log, facts)

    def _registers(self, folder: Path) -> Finding:
        given_up, different, facts = set[str](), set[str](), {}
        log = folder / "prove.log"
        for _ in range(_ROUNDS):
            (folder / "given_up").write_text("".join(f"{name}\n" for name in sorted(given_up)))
            tidy = "async2sync; setattr -unset init w:*; memory_map; opt_clean; splitnets"
            settle = "wreduce; opt -fine; opt_clean; " if self.settled else ""
            script = (
                f"read_verilog {_GATE} {_CELLS}; prep -flatten -top gate; {tidy}; design -stash gate; "
                f"read_rtlil {_GOLD}; prep -flatten -top {self.top}; rename {self.top} gold; {settle}{tidy}; "
                "design -copy-from gate gate; equiv_make -blacklist given_up gold gate equiv; "
                "hierarchy -top equiv; opt_clean; equiv_simple -seq 1; "
                f"equiv_induct -seq {self.clocks}; tee -o status equiv_status"
            )
            run_to_result([str(yosys()), "-p", script], folder / "status", log, folder)
            status = (folder / "status").read_text(encoding="utf-8")
            counts = re.search(r"Of those cells (\d+) are proven and (\d+) are unproven", status)
            if counts is None:
                raise InputError(f"equiv_status: no count (log: {log})")
            facts = {"points": int(counts[1])}
            different = set(re.findall(r"Unproven \$equiv \S+ \\?(\S+)_gold", status))
            ports = {name for name in different if name.partition("[")[0].endswith("_o")}
            if not int(counts[2]):
                nothing = () if facts["points"] else (f"{self.name}: nothing was compared",)
                return Finding(nothing, log, facts)
            if ports or not different - given_up:
                break
            given_up |= different
        some = ", ".join(sorted(different)[:3])
        return Finding((f"{self.name}: not shown equal to its netlist at {some} (log: {log})",), log, facts)


_RAM = "words in block or look-up-table RAM: no registers in the netlist to match those of the RTL with"
_PRODUCTS = "sums of products: no bit-level prover is expected to end; its multipliers are proved alone"
_LONG = "no proof found that goes through and ends within minutes"
_WHOLE = "as large as all its modules together"
# Why a module has no proof of its own. All but the first are simulated within the core, the engine or the
# board.
NOT_PROVED = {
    "CollisionDetector": "without a clock, for simulation: no build of the board has it",
    "nexys4ddr_top": _WHOLE,
    "triaxis_areas": _PRODUCTS,
    "triaxis_boxes": _LONG,
    "triaxis_certified_core": _WHOLE,
    "triaxis_certifier": _PRODUCTS,
    "triaxis_core": _WHOLE,
    "triaxis_datapath": _WHOLE,
    "triaxis_edges": _PRODUCTS,
    "triaxis_frame_rx": _RAM,
    "triaxis_group_rows": _RAM,
    "triaxis_mesh": _WHOLE,
    "triaxis_mesh_intake": _LONG,
    "triaxis_mesh_scrub": _LONG,
    "triaxis_mesh_store": _RAM,
    "triaxis_near_ring": _RAM,
    "triaxis_parity_ram": _RAM,
    "triaxis_plane_axes": _LONG,
    "triaxis_prisms": _PRODUCTS,
    "triaxis_projections": _LONG,
    "triaxis_ram": _RAM,
    "triaxis_receiver": _RAM,
    "triaxis_space_axes": _LONG,
    "triaxis_thresholds": _PRODUCTS,
    "triaxis_transmitter": _WHOLE,
    "triaxis_trapezoid": _PRODUCTS,
    "triaxis_walk": _WHOLE,
}


def _window(module: str, clocks: int, **parameters: int) -> ModuleProof:
    claim = f"After {clocks} clocks the netlist puts out what the RTL does, whatever both held before."
    return ModuleProof(f"triaxis_{module}", claim, Way.WINDOW, parameters, (), clocks)


_SETTLED = (
    "bits of registers that only ever take one value hold it from the start",
    "yosys takes those out of the RTL rightly (wreduce, opt), as it does in this synthesis",
)


def _registers(module: str, settled: bool = False, **parameters: int) -> ModuleProof:
    claim = (
        "From equal registers the netlist and the RTL put out the same, and hold the same after each clock."
    )
    taken = (
        "registers keep their names and state machines their numbers in this synthesis",
        "both begin with the same in all registers",
        *(_SETTLED if settled else ()),
    )
    return ModuleProof(f"triaxis_{module}", claim, Way.REGISTERS, parameters, taken, 2, settled)


_OF_BOARD = (
    "answer", "beat", "command", "crc32", "decimal", "display", "loader", "request", "reset_sync", "runner",
    "safety", "saturating_counter", "session", "slip_rx", "slip_tx", "uart_rx", "uart_tx", "watchdog",
)  # fmt: skip
# At widths at which provers end within a minute; those of W = 16 where they do.
PROOFS = (
    _window("apart", 8, W=16, M=16),
    _window("box", 8, W=16, M=16),
    _window("delay", 8, Cycles=4),
    _window("extent", 8, W=16),
    _window("flags", 8, W=16),
    _window("interval", 8, Points=3, Width=38, ThresholdWidth=36, M=16),
    _window("lane_mask", 8, Words=64, Lanes=8),
    _window("mul", 8, AWidth=17, BWidth=17),
    _window("narrow_mul", 8, WideWidth=17, NarrowWidth=3),
    _window("overlap", 8, W=16, Lanes=8),
    _window("reach", 12, W=4, M=3),
    _window("sum", 6, Terms=4, Width=16),
    _window("threshold", 8, M=3, CWidth=10),
    _window("verdict", 8),
    _registers("fifo", Depth=4),
    _registers("group_words", W=8, Groups=8, Lanes=2),
    _registers("grow", W=16),
    _registers("near_pairs", IndexWidth=4),
    _registers("pair_boxes", W=8, Depth=16, Group=4, Lanes=2),
    _registers("pair_fetch", W=8, Depth=16),
    _registers("pick", Lanes=4),
    _registers("run_control", W=8, MarginWidth=2),
    _registers("stream_fifo", Depth=4),
    _window("judge", 2, W=16, M=16, Depth=4096),
    *(_registers(module) for module in _OF_BOARD),
    # The inverted body is as wide as a reply, and has ones where that has its head.
    _registers("reply", settled=True),
)
