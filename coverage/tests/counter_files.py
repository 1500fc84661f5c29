"""Counters as Verilator writes them, for tests: a module with branches of all sorts, in two instances."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from triaxis.coverage.code_counters import FIRST_LINE, LAST_LINE

SOURCE = """\
module leaf;
  always_ff @(posedge clk_i) begin
    if (push_i) begin
      a_q <= d_i;
      b_q <= d_i;
    end else a_q <= '0;
    c_q <= a_q;
  end
  always_comb begin
    if (x == 0) y = 1;
    else if (x == 1) y = 2;
    else y = 3;
  end
  assign z = x < 0 ? 1 : 2; assign w = z ? 3 : 4;
  always_comb p = q; always_ff @(posedge clk_i) r <= p;
endmodule
"""
FIRST, SECOND = "TOP.top.u_first", "TOP.top.u_second"
# Line, column, type, what, lines: the bins of SOURCE.
BINS = (
    (2, 3, "line", "block", "2,7"),
    (3, 5, "branch", "if", "3-5"),
    (3, 6, "branch", "else", "6"),
    (9, 3, "line", "block", "9"),
    (10, 5, "line", "elsif", "10"),
    (11, 10, "line", "if", "11"),
    (11, 11, "line", "else", "12"),
    (14, 20, "branch", "cond_then", "14"),
    (14, 21, "branch", "cond_else", "14"),
    (14, 42, "branch", "cond_then", "14"),
    (14, 43, "branch", "cond_else", "14"),
    (15, 3, "line", "block", "15"),
    (15, 22, "line", "block", "15"),
)


def counter_line(file: Path, bin_: tuple[int, int, str, str, str], instance: str, count: int) -> str:
    """Return the line of one bin."""
    line, column, kind, what, lines = bin_
    fields = {"f": file, "l": line, "n": column, "t": kind, "page": f"v_{kind}/{file.stem}", "o": what}
    if lines:
        fields["S"] = lines
    fields["h"] = instance
    return "C '" + "".join(f"\x01{name}\x02{value}" for name, value in fields.items()) + f"' {count}"


def write_counters(path: Path, source: Path, counts: Mapping[str, Sequence[int]]) -> Path:
    """Write counters of SOURCE, those of its bins by instance, among bins of other kinds."""
    others = [
        counter_line(source, (4, 7, "toggle", "a_q[0]:0->1", ""), FIRST, 3),
        counter_line(source, (14, 14, "expr", "((x < 0)==0) => 0", ""), FIRST, 0),
    ]
    points = [
        counter_line(source, bin_, instance, count)
        for instance, numbers in counts.items()
        for bin_, count in zip(BINS, numbers, strict=True)
    ]
    path.write_text("\n".join([FIRST_LINE, *others, *points, LAST_LINE]) + "\n")
    return path
