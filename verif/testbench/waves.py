"""Waves of a run on the pins: the file, and views of it for GTKWave and Surfer, stream by stream."""

import re
import shutil
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path

from triaxis.golden.errors import InputError
from triaxis.golden.outputs import write_whole
from triaxis.sim.models import BOARD_TOP, MESH_TOP
from triaxis.sim.player import PERIOD_NS
from triaxis.verif.testbench.settings import PIN, VERILATOR, Block, RunSettings

WAVES = ("vcd", "fst")
DUMP = "waves.vcd"
_CONVERTER = "vcd2fst"
# GTKWave's: some thirty clocks in a window.
_ZOOM = "*-16.000000"
# Clocks before a failure at which a view begins: what led to it is in the window.
_BEFORE = 24
# Picoseconds, the unit of the file.
_CLOCK = 1000 * PERIOD_NS

Groups = Mapping[str, Sequence[str]]


_VERDICT = ("is_near", "axis", "coplanar", "degenerate_a", "degenerate_b")
_CORE: Groups = {
    "pairs in": ["clk_i", "rst_ni", "s_axis_tvalid_i", "s_axis_tready_o", "s_axis_tuser_i", "margin", "tag"],
    "their vertices": [f"{triangle}[{v}][{k}]" for triangle in "ab" for v in range(3) for k in range(3)],
    "stage by stage": [
        "valid_q", "in_flight_q", "u_datapath.valid_q", "u_datapath.box_separated",
        *(f"u_datapath.normal_{triangle}[{k}]" for triangle in "ab" for k in range(3)),
        "u_datapath.u_verdict.separated_i", "u_datapath.u_verdict.lowest_q", "u_datapath.u_verdict.claim",
    ],
    "verdicts out": [
        "m_axis_tvalid_o", "m_axis_tready_i", "m_axis_tuser_o",
        *(f"oldest.verdict.{field}" for field in _VERDICT),
    ],
}  # fmt: skip
_PINS = ("pairs in", "their vertices", "verdicts out")
_CERTIFIED: Groups = {
    "pairs in": [
        "clk_i", "rst_ni", "s_axis_tvalid_i", "s_axis_tready_o", "s_axis_tuser_i", "accepted_q", "margin",
    ],
    "in the core": [f"u_core.{one}" for group, names in _CORE.items() for one in names if group not in _PINS],
    "claims": [
        "claim_valid_q", "place_q", "claim", *(f"{triangle}[{v}][{k}]" for triangle in "ab" for v in range(3)
        for k in range(3)), "u_certifier.first_q", "u_certifier.second_q",
        *(f"u_certifier.axis_q[{k}]" for k in range(3)), "holds", "made",
    ],
    "verdicts out": [
        "m_axis_tvalid_o", "m_axis_tready_i", "m_axis_tuser_o", "m_axis_tdata_o", "delivered_q", "sound",
    ],
}  # fmt: skip
_MESH: Groups = {
    "meshes in": [
        "clk_i", "rst_ni", "s_axis_load_tvalid_i", "s_axis_load_tready_o", "s_axis_load_tuser_i", "count_a_o",
        "count_b_o",
    ],
    "runs in": [
        "s_axis_run_tvalid_i", "s_axis_run_tready_o", *(f"margins[{zone}]" for zone in range(3)),
        *(f"move[{k}]" for k in range(3)), "abort_i",
        "busy_o", "trial_q.kind", "trial_q.which", "g_walk[0].u_walk.u_control.state_q",
    ],
    "groups, boxes, pairs": [
        *(f"g_walk[0].u_walk.{name}" for name in ("row_valid", "row", "word_valid", "word_mask",
        "group_pair_valid", "masked_valid", "pair_valid")), "core_valid", "core_ready", "core_a", "core_b",
    ],
    "verdicts": ["verdict_valid", "verdicts_ready", "verdict", "verdict_pair"],
    "near pairs out": ["m_axis_near_tvalid_o", "m_axis_near_tready_i", "m_axis_near_tdata_o"],
    "ends of runs": [
        "m_axis_done_tvalid_o", "m_axis_done_tready_i", "status_o", "cycles_o", "group_pairs_skipped_o",
        "pairs_skipped_o", "tested_o", "near_o",
    ],
    "faults": ["broken", "stores_differ", "differ", "unlike", "fault", "acknowledge_i", "fault_o"],
}  # fmt: skip
_BOARD: Groups = {
    "line": [
        "clk_100mhz_i", "cpu_reset_ni", "rst_n", "uart_rx_i", "uart_tx_o", "frame_full", "frame_length",
        "frame_release", "link_error", "reply_valid", "reply_ready", "code",
    ],
    "go": [
        "go_o", "stop_o", "beyond_slow_o", "beyond_warn_o", "beat_o", "led_o", "alive", "expired", "refused",
        "fault", "g_safety[0].u_safety.armed_q",
    ],
    "session": [
        "hello", "load", "run", "free", "abort", "u_command.state_q", "u_command.u_session.session_q",
    ],
    "runner": ["busy", "aborting", "run_state", "run_mode", "done", "done_status", "near_count", "zones"],
    "engine": [
        "load_tvalid", "load_tready", "load_tuser", "count_a", "count_b", "run_tvalid", "run_tuser",
        "near_tvalid", "near_tready", "near_tdata", "ring_written", "ring_freed",
    ],
}  # fmt: skip


def check_waves(waves: str, agent: str, simulator: str) -> None:
    """Raise InputError where a run cannot leave such waves."""
    if agent != PIN:
        raise InputError("--waves: are of runs on the pins: say --agent pin")
    if simulator != VERILATOR:
        raise InputError("--waves: are of Verilator: leave out --simulator")
    if waves == "fst" and shutil.which(_CONVERTER) is None:
        raise InputError(
            f"--waves fst: {_CONVERTER}: not found: install GTKWave (apt-get install gtkwave), or take vcd"
        )


def signals_in(dump: Path) -> dict[str, int]:
    """Return the signals in a VCD file with their bits, by their path from the top module."""
    found: dict[str, int] = {}
    scopes: list[str] = []
    with dump.open(encoding="ascii", errors="replace") as lines:
        for line in lines:
            words = line.split()
            if words[:1] == ["$scope"]:
                scopes.append(words[2])
            elif words[:1] == ["$upscope"]:
                scopes.pop()
            elif words[:1] == ["$var"]:
                found[".".join([*scopes, words[4]])] = int(words[2])
            elif words[:1] == ["$enddefinitions"]:
                break
    return found


def view(settings: RunSettings) -> dict[str, list[str]]:
    """Return the groups of the view of a run, each with its signals as a VCD file names them."""
    if settings.block is Block.CORE:
        core = settings.configuration
        top, groups = core.top, _CERTIFIED if core.certified else _CORE
    else:
        top, groups = (MESH_TOP, _MESH) if settings.block is Block.MESH else (BOARD_TOP, _BOARD)
    return {title: [f"{top}.{name}" for name in names] for title, names in groups.items()}


def finished(folder: Path, settings: RunSettings, clock: int | None = None) -> Path | None:
    """Write views beside the waves of a run; return the file, converted if asked for, None without one.

    ``clock``: of the first failure; GTKWave then begins some clocks before it, and has its marker there.
    A signal that this configuration does not have is left out.
    """
    dump = folder / DUMP
    if not dump.exists():
        return None
    held = signals_in(dump)
    if settings.waves == "fst":
        whole = dump.with_suffix(".fst")
        command = [_CONVERTER, dump.name, whole.name]
        ran = subprocess.run(command, cwd=folder, check=False, capture_output=True, text=True)
        if ran.returncode:
            why = (ran.stderr.strip() or f"exit code {ran.returncode}").splitlines()[-1]
            raise InputError(f"{dump}: {_CONVERTER} cannot convert it: {why}: is the disk full? take vcd")
        dump.unlink()
        dump = whole
    marked, start = _CLOCK * (clock or 0), _CLOCK * max(0, (clock or 0) - _BEFORE)
    gtkwave, surfer = [f'[dumpfile] "{dump.name}"', f"[timestart] {start}", f"{_ZOOM} {marked}"], []
    for title, paths in view(settings).items():
        gtkwave += ["@200", f"-{title}"]
        surfer.append(f"divider_add {re.sub(r'[^a-z]+', '_', title)}")
        for path in (path for path in paths if path in held):
            bits = held[path]
            # As GTKWave's saved files have them: a bit, signed numbers (vertices, normals), hexadecimal.
            base = "@28" if bits == 1 else "@420" if path.endswith("]") else "@22"
            gtkwave += [base, path if bits == 1 else f"{path}[{bits - 1}:0]"]
            # Surfer has the elements of an array in a scope of their own.
            surfer.append(f"variable_add {path.replace('[', '.[')}")
    write_whole(dump.with_suffix(".gtkw"), "\n".join(gtkwave) + "\n")
    write_whole(dump.with_suffix(".sucl"), "\n".join([*surfer, "zoom_fit"]) + "\n")
    return dump
