"""Words of G-code that change where the tool is, or its shape, in ways that are not followed: why, and what
to do."""

_OFFSETS = (
    "moves the program's zero by a value of the control: remove it, or give absolute moves from program zero"
)
_CYCLE = "canned cycles are not supported: let the post-processor write plain moves"
_HOME = "goes to a position that only the machine knows: remove it, or write the move with G0"
_ROTARY = "only X, Y and Z move: remove it, or check each position with `triaxis check --rotate`"
_PLAIN = "belongs to a word that is not supported: remove it"

WHY_REFUSED = {
    "G2": "arcs are not supported: let the post-processor write them as G1 chords",
    "G3": "arcs are not supported: let the post-processor write them as G1 chords",
    "G5": "splines are not supported: let the post-processor write them as G1 chords",
    **dict.fromkeys(("G10", "G52", "G92", "G92.1", "G92.2", "G92.3"), _OFFSETS),
    **dict.fromkeys(("G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3"), _OFFSETS),
    **dict.fromkeys(("G28", "G28.1", "G30", "G30.1"), _HOME),
    "G53": "moves in machine coordinates, which only the machine knows: remove it, or write the move with G0",
    "G33": "threading is not supported: let the post-processor write plain moves",
    **dict.fromkeys(
        ("G38.2", "G38.3", "G38.4", "G38.5", "G31"),
        "probing ends where the part is: remove it from the program",
    ),
    **dict.fromkeys(
        ("G41", "G42", "G41.1", "G42.1"),
        "radius compensation moves the path by a value of the control: compensate in the post-processor",
    ),
    **dict.fromkeys(
        ("G43", "G43.1", "G43.2", "G43.4", "G44"),
        "length compensation moves the tool by a value of the control: give the tool's STL in its true place",
    ),
    **dict.fromkeys(
        ("G50", "G51", "G68", "G69"), "scaling and rotation of the program are not supported: remove it"
    ),
    "G64": "lets the control round corners, off the programmed path: use G61",
    **dict.fromkeys(("G73", "G76", *(f"G{code}" for code in range(81, 90))), _CYCLE),
    **dict.fromkeys(("G93", "G95"), "only feed per minute is supported: use G94"),
    "M19": "orients the spindle, and so turns the tool: remove it",
    **dict.fromkeys(("M97", "M98", "M99"), "subprograms are not supported: write them out"),
    **dict.fromkeys("ABCUVW", _ROTARY),
    **dict.fromkeys("DHIJKLQR", _PLAIN),
    "E": "not a word of a mill's program, and numbers take no exponent: write the number out",
    "O": "subprograms are not supported; a program number stands alone on its line: write them out",
}
