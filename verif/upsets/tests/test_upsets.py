"""Upsets are judged by go, and by what a host is told, against what is true; and there are some."""

import re
from dataclasses import replace

import numpy as np
import pytest

from triaxis.host.link.messages import NO_ZONES, ZONES, Begun, Flag, Mode, RunRequest, Status
from triaxis.sim.build import rtl_files
from triaxis.sim.paths import DUT
from triaxis.sim.player import Register
from triaxis.sim.simulated_board import EVENT, PINS, TX
from triaxis.verif.board.board_state import BEYOND
from triaxis.verif.board.protocol import HEAD, REPLY, Command, framed
from triaxis.verif.upsets import builds, campaign
from triaxis.verif.upsets.builds import MEASURES, module_of, registers, without_measures
from triaxis.verif.upsets.fmeda import BLOCKS, block_of
from triaxis.verif.upsets.upset_test import grouped
from triaxis.verif.upsets.verdict import (
    EARLY,
    LATE,
    Asked,
    AskedRun,
    Fate,
    Kind,
    Truth,
    Upset,
    permitted,
    runs,
)

SESSION, RUN = 7, 1
GO, STOP = 1, 2
BEYOND_SLOW, BEYOND_WARN = 1 << BEYOND, 1 << BEYOND + 1
GOES, ENDS, OVER, WATCHDOG = 5000, 50_000, 80_000, 20_000
WHOLE = (GOES, ENDS)


def said_of(*go, beyond=()):
    """Return what is said where go is, and beyond slow, at these times."""
    return {"go": go, "beyond slow": beyond, "beyond warn": ()}


def truth(near):
    """Return what holds where a run, at a pose that is near or not, is asked for, and its results."""
    run = AskedRun(RunRequest(Mode.ALL, 0, *NO_ZONES, 1, 1, z=3 if near else 0), RUN, near)
    heads = [
        (command | REPLY, number, SESSION) for number, command in enumerate((Command.RUN, Command.RESULTS))
    ]
    script = Asked(0, b"", heads[0], Begun(RUN, 0)), Asked(10_000, b"", heads[1], run=run)
    return Truth(script, said_of() if near else said_of(WHOLE), 8, WATCHDOG, OVER)


def answer(number, command, payload, pairs=b"", code=0):
    twice = payload + bytes(byte ^ 0xFF for byte in payload)
    return framed(HEAD.pack(command | REPLY, number, SESSION) + bytes([code]) + twice + pairs)


def results(count, z=0, first=0, **changes):
    # It asks for no zones, so it is beyond none.
    flags = ZONES | (Flag.NEAR_WAITING if count else 0)
    status = Status(RUN, 2, 1, flags, Mode.ALL, 0, 0, z, 0, 20, 0, 1, 0, 1, count, 0, 1, 1)
    head = first.to_bytes(4, "little") + bytes([count])
    return answer(1, Command.RESULTS, replace(status, **changes).pack() + head, bytes(4 * count))


def seen(said, *go):
    """Return what is seen: bytes of the board, and go from each of some clocks to another."""
    levels = [(clock, level) for first, last in go for clock, level in ((first, GO), (last, STOP))]
    rows = [(clock, PINS, level) for clock, level in levels]
    rows += [(20_000, TX, byte) for byte in said]
    return np.array(sorted(rows, key=lambda row: row[0]), EVENT)


BEGUN = answer(0, Command.RUN, bytes([RUN, 0, 0]))


@pytest.mark.parametrize(
    ("near", "said", "go", "fate"),
    [
        (False, BEGUN + results(0), [WHOLE], Fate.NO_EFFECT),
        (False, BEGUN + results(0), [(GOES, ENDS + LATE)], Fate.NO_EFFECT),
        (False, BEGUN + results(0), [(GOES, ENDS + LATE + 1)], Fate.DANGEROUS),
        (False, BEGUN + results(0), [(GOES - EARLY, ENDS)], Fate.NO_EFFECT),
        (False, BEGUN + results(0), [(GOES - EARLY - 1, ENDS)], Fate.DANGEROUS),
        (False, BEGUN + results(0), [(GOES, GOES + 1)], Fate.FALSE_STOP),
        (False, BEGUN + results(0), [(GOES, GOES + 9000), (GOES + 9001, ENDS)], Fate.FALSE_STOP),
        (False, BEGUN + results(0), [WHOLE, (ENDS + 9000, ENDS + 9001)], Fate.DANGEROUS),
        (False, BEGUN + results(0), [], Fate.FALSE_STOP),
        (False, BEGUN + results(1), [WHOLE], Fate.FALSE_STOP),
        (False, BEGUN, [WHOLE], Fate.DETECTED),
        (False, BEGUN + results(0)[:-4], [WHOLE], Fate.DETECTED),
        (False, answer(0, Command.RUN, bytes([RUN + 1])) + results(0), [WHOLE], Fate.DETECTED),
        (False, answer(0, Command.RUN, b"", code=5) + results(0), [WHOLE], Fate.DETECTED),
        (True, BEGUN + results(1, 3), [], Fate.NO_EFFECT),
        (True, BEGUN + results(1, 3), [(GOES, GOES + 1)], Fate.DANGEROUS),
        (True, BEGUN + results(0, 3), [], Fate.DANGEROUS),
        # Near pairs that begin with another than the first.
        (True, BEGUN + results(1, 3, first=1), [], Fate.DETECTED),
        # What a host does not believe it does not take for clear.
        (True, BEGUN + results(0, 2), [], Fate.DETECTED),
        (True, BEGUN + results(0, 3, tested=0), [], Fate.DETECTED),
        (True, BEGUN + results(0, 3, near=1), [], Fate.DETECTED),
        (True, BEGUN + results(1, 3, flags=1), [], Fate.DETECTED),
    ],
)
def test_go_or_clear_where_something_is_near_is_dangerous(near, said, go, fate):
    assert truth(near).judge(seen(said, *go), 2)[0] is fate


def test_the_machine_may_move_where_go_is_said_and_stop_is_not():
    fault = np.array([(GOES, PINS, GO | STOP), (ENDS, PINS, STOP)], EVENT)
    assert permitted(fault, OVER) == said_of()
    assert permitted(seen(b"", WHOLE), OVER) == said_of(WHOLE)


@pytest.mark.parametrize(
    ("said", "fate"),
    [
        (BEYOND_SLOW, Fate.NO_EFFECT),
        (0, Fate.FALSE_STOP),
        (BEYOND_WARN, Fate.DANGEROUS),
        (BEYOND_SLOW | BEYOND_WARN, Fate.DANGEROUS),
    ],
)
def test_beyond_a_zone_where_something_is_in_it_is_dangerous(said, fate):
    one = replace(truth(near=False), due=said_of(WHOLE, beyond=(WHOLE,)))
    events = seen(BEGUN + results(0), WHOLE)
    events["value"][(events["kind"] == PINS) & (events["value"] == GO)] |= said
    assert one.judge(events, 2)[0] is fate


def test_a_host_that_does_not_believe_an_answer_is_silent():
    """Go that was said may go on until the watchdog; none may begin after that."""
    script = truth(near=False).script
    more = replace(
        truth(near=False), script=(*script, Asked(40_000, b"")), due=said_of(WHOLE, (60_000, 70_000))
    )
    later = 40_000 + WATCHDOG
    for first, last, sent, fate in (
        (GOES, later, 2, Fate.DETECTED),
        (GOES, later + LATE + 1, 2, Fate.DANGEROUS),
        (60_000, 61_000, 2, Fate.DANGEROUS),
        (GOES, later, 3, Fate.DANGEROUS),
    ):
        assert more.judge(seen(b"", (first, last)), sent)[0] is fate


def test_upsets_share_a_copy_where_they_are_in_words_of_memories():
    memory, mesh = Register("u_ring.memory_q", 8, 4), Register("top.u_store_a.memory_q", 8, 4)
    state = Register("state_q", 1, 3)
    upsets = [
        Upset(kind, one.name, element, 0, clock, running=False)
        for clock, (kind, one, element) in enumerate(
            [
                (Kind.FLIP, memory, 0), (Kind.FLIP, state, 0), (Kind.FLIP, memory, 1), (Kind.FLIP, mesh, 0),
                (Kind.STUCK_AT_0, memory, 2), (Kind.FLIP, memory, 1), (Kind.FLIP, memory, 3),
            ]
        )
    ]  # fmt: skip
    groups = grouped(upsets, (memory, mesh, state))
    assert sorted([one.clock for one in group] for group in groups) == [[0, 2], [1], [3], [4], [5, 6]]


def test_each_measure_can_be_taken_away(tmp_path, monkeypatch):
    """The diffs fit the RTL, alone and together."""
    monkeypatch.setattr(builds, "FOLDER", tmp_path)
    for some in (MEASURES, *((measure,) for measure in MEASURES)):
        changed = without_measures(some)
        differ = [one for one in rtl_files(changed) if one.read_bytes() != same(one, changed).read_bytes()]
        assert differ and len(differ) <= len(some)


def same(file, folder):
    return DUT / file.relative_to(folder)


def test_the_share_that_is_not_exceeded():
    # None of n: 1 - 0.05^(1/n). Of one in ten Clopper and Pearson's table has 0.394.
    assert campaign.most_share(0, 30_000) == pytest.approx(1 - 0.05 ** (1 / 30_000))
    assert campaign.most_share(1, 10) == pytest.approx(0.394, abs=5e-4)
    assert campaign.most_share(10, 10) == 1.0


def test_a_register_is_of_the_module_that_assigns_it():
    place = "TOP.nexys4ddr_top.u_mesh.u_store_b.g_lane[0].u_boxes.u_words.memory_q"
    assert module_of(place) == "triaxis_ram"
    assert module_of("TOP.nexys4ddr_top.g_safety[0].u_safety.go_q") == "triaxis_safety"
    core = "TOP.nexys4ddr_top.u_mesh.g_core.u_core"
    assert module_of(f"{core}.valid_q") == "triaxis_certified_core"
    assert module_of(f"{core}.u_core.valid_q") == "triaxis_core"
    named = registers()
    assert {"go_q", "armed_q"} <= set(named["triaxis_safety"])
    # By the macro of the data path's stages, from braces, and at outputs.
    assert "edge_q" in named["triaxis_edges"] and "move_o" in named["triaxis_run_control"]


@pytest.mark.regress
@pytest.mark.simulator
def test_upsets_of_the_board_are_seen(tmp_path, seed, monkeypatch):
    """Some have an effect; each comes to an end; and one that is dangerous is told."""
    monkeypatch.setattr(campaign, "FOLDER", tmp_path)
    for name, file in (("RESULT", "upsets.json"), ("TABLE", "fmeda.md"), ("PLOT", "measures.svg")):
        monkeypatch.setattr(campaign, name, tmp_path / file)
    told: list[int] = []
    result = campaign.upset_board(told.append, seed, 300)
    # Of so few tried without the measures none may be dangerous, which is told.
    assert [line.split(":")[0] for line in result.problems] == (
        [] if result.left["none"] else ["nothing is dangerous without the measures"]
    )
    result = replace(result, problems=())
    assert sum(told) == len(result.outcomes) == 300
    assert [len(result.of(kind)) for kind in Kind] == [273, 9, 9, 9] and len(result.without) == 60
    assert list(result.left) == ["none", *(measure.name for measure in MEASURES)]
    assert (
        campaign.tally(list(result.outcomes)).detected and len(campaign.by_module(result.of(Kind.FLIP))) > 20
    )
    assert sum(result.bits.values()) > 50_000 and len(result.of(*Kind, running=True)) == 150
    assert set(map(block_of, result.bits)) == {block.name for block in BLOCKS}
    assert sum(one.tried for one in campaign.by_block(result).values()) == 300
    assert all(re.fullmatch(r"triaxis_\w+|nexys4ddr_top", one.module) for one in result.outcomes)
    assert campaign.write_result(result).exists()
    assert campaign.TABLE.read_text().count("\n") == 2 + len(BLOCKS) and campaign.PLOT.exists()
    wrong = replace(result, outcomes=(*result.outcomes, replace(result.outcomes[0], fate=Fate.DANGEROUS)))
    assert not wrong.passed and len(wrong.dangerous) == len(result.dangerous) + 1


@pytest.mark.long
@pytest.mark.simulator
def test_a_pose_that_changes_before_its_run_begins_gives_no_go(tmp_path, seed, monkeypatch):
    """The pose of the second run, at which a pair is near, as each of the two runners is given it."""
    monkeypatch.setattr(campaign, "FOLDER", tmp_path)
    board = campaign._Campaign(campaign.CONFIG, seed, lambda _: None)
    assert len(board.run(33)) == 33
    with np.load(tmp_path / "run" / "undisturbed.npz") as kept:
        begins = runs(kept["events"], int(kept["events"]["clock"][-1]))[1][0]
    # The last fields are z, of four bytes, and the hold, of two.
    size = HEAD.size + len(RunRequest(Mode.ALL, 0, *NO_ZONES, 1, 1).pack())
    kept = "TOP.nexys4ddr_top.u_command.g_request[{}].u_request.request_q"
    changes = [
        Upset(Kind.FLIP, kept.format(copy), 0, 8 * (size - 6) + bit, begins - 3, running=False)
        for copy in range(2)
        for bit in range(8)
    ]
    outcomes = board.run(len(changes), upsets=changes)
    assert not board.problems and {one.fate for one in outcomes} <= {Fate.DETECTED, Fate.FALSE_STOP}, outcomes
