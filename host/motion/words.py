"""The G and M words that are understood, by modal group, and why the others are not."""

# Modal groups: of each, one word on a line. Those of "-" change nothing of where the tool is.
GROUPS = {
    code: group
    for group, codes in (
        ("motion", "G0 G1 G2 G3 G5 G5.1 G5.2 G5.3 G33"), ("motion", "G73 G74 G81 G82 G83 G84 G85 G86 G89"),
        ("cycle", "G80"), ("distance", "G90 G91"), ("arc distance", "G90.1 G91.1"), ("units", "G20 G21"),
        ("plane", "G17 G18 G19"), ("radius compensation", "G40"), ("length compensation", "G43 G49"),
        ("work offset", "G54 G55 G56 G57 G58 G59 G59.1 G59.2 G59.3"), ("path mode", "G61 G61.1 G64"),
        ("feed mode", "G93 G94 G95"), ("retract", "G98 G99"), ("spindle mode", "G96 G97"),
        ("diameter", "G8"), ("no modal group", "G4 G10 G28 G30 G52 G53 G92 G92.1 G92.2 G92.3"),
        ("stop", "M0 M1 M2 M30 M60"), ("spindle", "M3 M4 M5"), ("tool change", "M6 M61"), ("mist", "M7"),
        ("flood", "M8"), ("coolant off", "M9"), ("overrides", "M48 M49 M50 M51 M52 M53"),
        ("input and output", "M62 M63 M64 M65 M66 M67 M68"),
    )
    for code in codes.split()
}  # fmt: skip
# Words of no modal group that take the axes of their line.
TAKING_AXES = frozenset(("G10", "G28", "G30", "G52", "G92"))
CYCLES = frozenset(("G73", "G74", "G81", "G82", "G83", "G84", "G85", "G86", "G89"))
ARCS = frozenset(("G2", "G3"))
# Which words take a letter; it is refused where none of them is on the line, or in force.
TAKERS = {
    "I": ARCS | {"G5", "G5.1"}, "J": ARCS | {"G5", "G5.1"}, "K": ARCS | {"G33"}, "R": ARCS | CYCLES | {"G10"},
    "P": ARCS | CYCLES | {"G4", "G5", "G5.2", "G10", "G64"}
    | {f"M{n}" for n in (50, 51, 52, 53, *range(62, 67))},
    "Q": CYCLES | {"G5", "G64", "M61", "M66", "M67", "M68"}, "L": CYCLES | {"G5.2", "G10", "M66"},
    "H": {"G43"}, "E": {"M66", "M67", "M68"}, "D": {"G96"},
}  # fmt: skip
# Words that change where the tool is, or its shape, in ways that are not followed: why, and what to do.
_POST = "let the post-processor write it as plain moves"
WHY_REFUSED = {
    code: why
    for codes, why in (
        ("G6.2 G6.3", f"is not followed: {_POST}"),
        ("G7", "X in diameters is not followed: let the post-processor write radii (G8)"),
        ("G10.1 G28.1 G30.1", "changes what the control keeps: give its values in a machine file"),
        ("G33.1 G76 G87 G88", f"is not followed: {_POST}"),
        ("G31 G38.2 G38.3 G38.4 G38.5",
         "probing ends where the part is, which nobody knows before: what follows it cannot be checked"),
        ("G41 G42 G41.1 G42.1",
         "radius compensation is followed by LinuxCNC's interpreter alone: give --reader rs274, or let the "
         "post-processor compensate"),
        ("G43.1 G43.2 G44", "is not followed: let the post-processor write G43 with H, of the same length"),
        ("G43.4 G43.5", "a tool whose tip is kept in place by axes that turn is not followed"),
        ("G50 G51 G68 G69", f"scaling and rotation of the program are not followed: {_POST}"),
        ("G70 G71 G71.1 G71.2 G72 G72.1 G72.2", f"lathe cycles are not followed: {_POST}"),
        ("M70 M71 M72 M73", "what it keeps and brings back is not followed: write the modal words"),
        ("M19", "orients the spindle, and so turns the tool, which is not followed"),
        ("M97 M98 M99", "is not followed: call subroutines with O words"),
        ("A B C U V W",
         "not an axis of the machine: only X, Y, Z move, and A, B, C where objects of a machine file turn"),
        ("D E H I J K L P Q R", "belongs to a word that is not on the line: correct it"),
    )
    for code in codes.split()
}  # fmt: skip
