"""The chain from the definition of distance to the gates: what a sign-off proved, checked, or did not."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from triaxis.verif.formal.proof import Result
from triaxis.verif.signoff.parts import Evidence, Part

# The proof of the contract, and what the names of those about the mesh engine and the board begin with.
THEOREM, _ENGINE, _BOARD = "theorem", "engine_", "board_"


class State(StrEnum):
    """What a sign-off can say of a link."""

    PROVED = "proved"
    CHECKED = "checked"
    FAILED = "failed"
    ABSENT = "not measured"
    # No tool of ours looks at it, whatever is installed.
    OUTSIDE = "not covered"


@dataclass(frozen=True)
class Link:
    """One step of the chain: from what to what, what holds, by which tool, how much of it."""

    step: str
    holds: str
    tool: str
    amount: str
    state: State

    @property
    def content(self) -> dict[str, str]:
        """Return the link as it stands in the file."""
        return {**vars(self), "state": self.state.value}


def chain(parts: Mapping[str, Part], beside: Mapping[str, Part]) -> list[Link]:
    """Return the links in order, from the evidence of a sign-off and of the results that stand beside it."""
    return [
        _proved(
            "distance to 32 axes",
            "two triangles are near at a margin exactly where none of the 32 axes separates them; rounding "
            "misses nothing",
            "Coq",
            parts["proofs"],
            lambda name: name == THEOREM,
        ),
        _proved(
            "32 axes to RTL",
            "the core decides by these and no others, for all inputs, and loses none; what is wide at all "
            "widths, what repeats at one",
            "algebra on the netlist of yosys; SymbiYosys with yices",
            parts["proofs"],
            lambda name: name != THEOREM and not name.startswith((_ENGINE, _BOARD)),
            "axes_margins",
        ),
        _proved(
            "32 axes to RTL",
            "a run of the mesh engine loses no pair and skips only what boxes separate, for all meshes, "
            "poses, stalls and aborts, at a small size; core and memories, stand-ins there, have proofs of "
            "their own",
            "SymbiYosys with yices",
            parts["proofs"],
            lambda name: name.startswith(_ENGINE),
            "engine_walk",
        ),
        _checked(
            "32 axes to RTL",
            "answers equal those of the golden model and the bulk checker",
            "Verilator, pyuvm",
            parts["simulation"],
            lambda found: f"{found['pairs_checked']:,} pairs, {found['mismatches']:,} wrong",
        ),
        _checked(
            "32 axes to RTL",
            "what would be wrong is noticed",
            "mutants of dut/, by the same tests",
            parts["mutation"],
            _mutants,
        ),
        _proved(
            "RTL to the machine",
            "go implies a clear run on what was acknowledged to a host heard in time, for any frames",
            "SymbiYosys with yices",
            parts["proofs"],
            lambda name: name.startswith(_BOARD),
            "board_go",
        ),
        _checked(
            "two states to four",
            "nothing unknown reaches an output that counts",
            "Icarus Verilog, the same tests",
            beside["four_state"],
            lambda found: str(found["summary"]),
        ),
        _checked(
            "RTL to netlist",
            "the cells that yosys leaves answer as the RTL; modules proved equal, or named with the reason",
            "yosys, Verilator; SymbiYosys with yices",
            beside["netlist"],
            lambda found: str(found["summary"]),
        ),
        Link(
            "netlist to bitstream",
            "Vivado's own synthesis, placement and routing, and the timing of the part",
            "none here: Vivado's reports, in front of `make bitstream`",
            "",
            State.OUTSIDE,
        ),
        Link(
            "a bit that turns over",
            "go falls, and nothing is said to be clear, where a register or memory of the FPGA is upset",
            "asked for by no sign-off: `make upsets` tries bits one by one, and counts the dangerous",
            "",
            State.OUTSIDE,
        ),
    ]


def _state(part: Part, good: State) -> State:
    if part.evidence is None:
        return State.ABSENT
    return good if part.evidence["passed"] else State.FAILED


def _checked(step: str, holds: str, tool: str, part: Part, amount: Callable[[Evidence], str]) -> Link:
    counted = part.absent or "" if part.evidence is None else amount(part.evidence)
    return Link(step, holds, tool, counted, _state(part, State.CHECKED))


def _proved(
    step: str, holds: str, tool: str, part: Part, chosen: Callable[[str], bool], main: str = ""
) -> Link:
    """Return the link of some proofs; ``main``: the one whose size is told."""
    if part.evidence is None:
        return Link(step, holds, tool, part.absent or "", State.ABSENT)
    proofs = [proof for proof in part.evidence["proofs"] if chosen(proof["name"])]
    passed = sum(proof["passed"] is True for proof in proofs)
    results = {proof["result"] for proof in proofs}
    if not proofs or results == {Result.ABSENT}:
        state = State.ABSENT
    else:
        state = State.PROVED if passed == len(proofs) else State.FAILED
    sizes = [f"; `{main}` at {_size(proof['parameters'])}" for proof in proofs if proof["name"] == main]
    return Link(step, holds, tool, "".join([f"{passed:,} of {len(proofs):,} proofs", *sizes]), state)


def _size(parameters: Mapping[str, Any]) -> str:
    return ", ".join(
        f"{value.count(',') + 1} {name}" if name == "configurations" else f"{name} = {value:,}"
        for name, value in parameters.items()
    )


def _mutants(found: Evidence) -> str:
    files: Sequence[Mapping[str, Any]] = list(found["files"].values())
    mutants, killed, equivalent = (
        sum(file[key] for file in files) for key in ("mutants", "killed", "equivalent")
    )
    return f"{mutants:,} mutants: {killed:,} killed, {equivalent:,} shown equivalent"


def unmeasured(beside: Mapping[str, Part]) -> list[str]:
    """Return which results do not stand beside a sign-off, a line each."""
    absent = {name.replace("_", " "): part.absent for name, part in beside.items() if part.evidence is None}
    return [f"{name}: {State.ABSENT}: {reason}" for name, reason in absent.items()]
