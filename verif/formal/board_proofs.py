"""The board's proofs: what its go implies, and the frames, runs and replies that this rests on."""

from triaxis.verif.formal.proof import WIDTH, SbyProof, harness_proof

# The board, from its top down, without what stands in for it.
_BOARD = (
    "board/nexys4ddr_top",
    *(
        f"board/triaxis_{module}"
        for module in (
            "beat", "safety", "answer", "saturating_counter", "runner", "watchdog", "request", "command",
            "loader", "judge", "session", "reset_sync",
        )
    ),
)  # fmt: skip

# As it ships: of the top's own times those that go rests on.
_BOARD_SIZES = {
    "W": WIDTH, "M": WIDTH, "Depth": 4096, "WatchdogClocks": 10_000_000, "HoldClocks": 100_000,
}  # fmt: skip


def _board_twice() -> SbyProof:
    return harness_proof(
        "board_twice",
        "Whatever the one of two does, the other permits nothing but from the end of a complete run that "
        "found nothing near, to the deadline that it counts itself, and on its own sign of life, with no "
        "change, error or fault since; go is that of the one, stop the contrary of the other; what is "
        "beyond a zone both must say, each with its own go alone, of what the run that began it found; "
        "for any states of the two. Each of two runners is asked by a request of its own; a command is "
        "executed where two registers say that it was judged in the last clock, whole and good. Two "
        "runners that differ in anything that they say or ask for, a byte that is broken, and what is "
        "tried of these, are a fault in the next clock, and nothing else is, until the next HELLO; a "
        "fault is told to the host, and so are margin, pose, zones and number of the first, whole.",
        _BOARD,
        _BOARD_SIZES,
        2,
        ("the engine tells its faults: `engine_checks`; a frame its own: `board_frame`",),
        window=True,
        beside=("triaxis_board_surroundings",),
        harness="triaxis_board_twice_formal",
    )


def _board_go() -> SbyProof:
    return harness_proof(
        "board_go",
        "For all time, from power-up: go is said only where the last run that the engine ended was "
        "complete and found nothing near, and its hold, if it has one, is not over; a run that has begun "
        "since then holds; both are as they were acknowledged to the host: pose, margins, mode and trial "
        "asked for; the meshes are those acknowledged, byte by byte, as many triangles as the runs named, "
        "and nothing was loaded since; no frame was damaged or refused since the last run was asked for; a "
        "command that was no repeat was acknowledged at most WatchdogClocks + 1 clocks ago; and no fault "
        "stands, or has come since that run was asked for, and a fault stands until a HELLO. Go lasts until "
        "one of these ends it, whatever was found in the outer zones; beyond a zone is said exactly with "
        "go, where the last run that ended looked at it and found nothing in it. Go and stop always differ; "
        "the beat ends with go. The signatures that a LOAD is answered with are the engine's.",
        _BOARD,
        _BOARD_SIZES,
        10,
        (
            "frames are whole, have their CRC and stay until they are released: shown by `board_frame`, "
            "`board_slip` and `board_bytes`; they come at any clocks",
            "the engine takes nothing during a run, and ends it once: shown by `engine_control`; it counts "
            "and places triangles: shown by `engine_boxes`; what it says of a run is free, and is what the "
            "other proofs of the engine and the core make of it",
            "replies leave at any pace, and what RESULTS may ask for is anything",
        ),
        beside=("triaxis_board_surroundings",),
        harness="triaxis_go_formal",
        resets=False,
        cover_from_reset=False,
    )


def _board_reply() -> SbyProof:
    return harness_proof(
        "board_reply",
        "For all time: a request is answered once, with the head and the payload that the protocol "
        "gives that answer, every byte at its place, the payload again inverted, the near pairs "
        "of the ring from the number asked for, and their own CRC-32; nothing else is sent. A byte is "
        "offered in each clock, or in the one after it, until all are sent.",
        ("board/triaxis_reply", "board/triaxis_answer", "board/triaxis_crc32"),
        {"IndexWidth": 12},
        4,
        (
            "only a LOAD is refused for its place, and only known commands are executed: shown by `board_go`",
            "the ring gives the pair of a number a clock after that: words of a memory, shown by "
            "`engine_memory`",
        ),
        cover_from_reset=False,
    )


def board_proofs() -> tuple[SbyProof, ...]:
    """Return the proofs of the board, the longest first."""
    return (
        _board_reply(),
        _board_go(),
        _board_twice(),
        harness_proof(
            "board_bytes",
            "For all time and for any line: a byte is given exactly where one was, each of its bits as "
            "the line was in the middle of it, after a start bit and before a stop bit; without a stop "
            "bit it is an error, told once.",
            ("board/triaxis_uart_rx",),
            {"ClocksPerThreeBits": 25},
            54,
            cover_from_reset=False,
        ),
        harness_proof(
            "board_line",
            "For all time and for any bytes: each that is accepted is on the line from the next clock "
            "on, start bit, its bits, stop bit, each as long as the rate says to a clock; then the next "
            "is accepted; the line is high besides.",
            ("board/triaxis_uart_tx",),
            {"ClocksPerThreeBits": 25},
            3,
            cover_from_reset=False,
        ),
        harness_proof(
            "board_ring",
            "For all time: the ring takes every near pair until it holds 1,024, and those that it holds "
            "are given by their numbers, which have 32 bits; what finds no place waits, or is dropped "
            "where a run is aborted.",
            ("board/triaxis_near_ring", "mesh/triaxis_ram"),
            {"Width": 24, "Entries": 1024},
            3,
            ("pairs are freed up to one that is held, or to the next: no other RESULTS is executed",),
            cover_from_reset=False,
        ),
        harness_proof(
            "board_frame",
            "For all time and under any bytes, ends and errors: a frame that is handed out is what came "
            "between two ends, 13 to 256 bytes, unchanged until it is released, its last four the "
            "complement of the remainder of the others divided by the polynomial of CRC-32; every such "
            "frame is handed out unless it came while another was held; every other is told as an error. "
            "A byte of it that is shown is told as broken where one bit of it or of its parity is "
            "inverted, or that is tried, and otherwise not.",
            ("board/triaxis_frame_rx", "board/triaxis_crc32"),
            {},
            18,
            ("of byte, end and error one comes at a time: shown by `board_slip`",),
            edits={
                "board/triaxis_frame_rx.sv": (
                    (
                        "logic parity, shown;\n  assign {parity, data_o} = memory_q[address_i];",
                        "logic parity, shown;\n  logic [8:0] free_inverted;\n"
                        "  assign {parity, data_o} = memory_q[address_i] ^ free_inverted;",
                    ),
                )
            },
        ),
        harness_proof(
            "board_slip",
            "For all time and for any line: nothing is given but from an END on and up to what is wrong or "
            "the next END, and what is wrong is told; what the encoder makes of a frame is given back byte "
            "by byte, with an end and without an error.",
            ("board/triaxis_slip_rx", "board/triaxis_slip_tx"),
            {},
            6,
            ("frames for the encoder stay as they are until they are taken",),
        ),
        harness_proof(
            "board_runs",
            "For all time: what is said of a run is what the engine said at its end, every number of the "
            "summary and the zones whole, until the next run or HELLO, and zeros before; the run is the one "
            "that was asked for, pose, margins, trial and hold included, and its number counts the runs "
            "since HELLO.",
            ("board/triaxis_runner",),
            {"W": WIDTH, "M": WIDTH},
            10,
            (
                "commands come one at a time, none but ABORT during a run: shown by `board_go`",
                "the engine ends a run once: shown by `engine_control`",
            ),
        ),
        harness_proof(
            "board_errors",
            "For all time: the count of errors grows by what happens in a clock, two things at most, and "
            "stays at the largest number that it can show.",
            ("board/triaxis_saturating_counter",),
            {"Width": 12},
            3,
            cover_from_reset=False,
        ),
    )
