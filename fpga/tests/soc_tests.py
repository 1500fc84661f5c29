"""Tests of the AXI4-Lite top: through PeakRDL's register model of pyuvm, and the AXI master of cocotb-bus.

The register model is where Python looks for modules; the parameters of the build are given as plusargs.
"""

import zlib
from importlib import import_module
from itertools import product
from typing import Any

import cocotb
import numpy as np
import pyuvm
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, FallingEdge, ReadOnly
from cocotb.utils import get_sim_time
from cocotb_bus.drivers.amba import AXI4LiteMaster
from pyuvm import (
    uvm_access_e,
    uvm_driver,
    uvm_env,
    uvm_reg_adapter,
    uvm_sequence_item,
    uvm_sequencer,
    uvm_status_e,
    uvm_test,
)

from triaxis.golden.bulk import bulk_facts
from triaxis.golden.pairs import coordinate_range

NONE, COMPLETE, FIRST, ABORTED, OVERFLOW, OVERFULL, BAD_MODE, FAULT = range(8)
MODE_FIRST, MODE_ALL, MODE_COUNT, MODE_NONE = range(4)
DONE, FAULTED, REFUSED, NEAR_WAITS = 1, 2, 4, 8
A, B, CLEAR = 0, 1, 2
# Where the bus is held up a test would wait for ever: some six times what the longest takes.
LIMIT = {"timeout_time": 2, "timeout_unit": "ms"}
MARGINS = ("MARGIN", "SLOW", "WARN")
# triaxis_mesh_pkg: kind 4: the triangles of A where a run uses them; the CRC of the scrub after a run.
TRY_MEMORY, TRY_SCRUB = 4 << 5 | 4, 4 << 5 | 16


class Axi(AXI4LiteMaster):
    """The master of cocotb-bus on ports whose names say their direction."""

    _signals = {  # noqa: RUF012
        **{name: f"{name.lower()}_i" for name in ("AWVALID", "AWADDR", "WVALID", "WDATA", "WSTRB", "BREADY")},
        **{name: f"{name.lower()}_i" for name in ("ARVALID", "ARADDR", "RREADY", "AWPROT", "ARPROT")},
        **{name: f"{name.lower()}_o" for name in ("AWREADY", "WREADY", "BVALID", "BRESP", "ARREADY")},
        **{name: f"{name.lower()}_o" for name in ("RVALID", "RRESP", "RDATA")},
    }


class Access(uvm_sequence_item):
    """A read or a write of a register."""

    def __init__(self, operation):
        super().__init__("access")
        self.operation = operation


class Adapter(uvm_reg_adapter):
    """Accesses as the register model knows them."""

    def reg2bus(self, rw):
        return Access(rw)

    def bus2reg(self, bus_item: Any, rw: Any):
        rw.data, rw.status = bus_item.operation.data, bus_item.operation.status


class Driver(uvm_driver):
    """Does what is asked, an access after the other."""

    async def run_phase(self):
        top: Any = cocotb.top
        self.axi = Axi(top, "s_axil", top.clk_i)
        while True:
            item = await self.seq_item_port.get_next_item()
            operation = item.operation
            if operation.kind == uvm_access_e.UVM_WRITE:
                await self.axi.write(operation.addr, operation.data)
            else:
                operation.data = int(await self.axi.read(operation.addr))
            operation.status = uvm_status_e.UVM_IS_OK
            self.seq_item_port.item_done()


class Environment(uvm_env):
    """A driver on the bus, and the register model above it."""

    def build_phase(self):
        self.sequencer = uvm_sequencer("sequencer", self)
        self.driver = Driver("driver", self)
        self.registers = import_module("triaxis_soc_ral").triaxis_soc_regs("registers")
        self.registers.build()
        self.registers.lock_model()

    def connect_phase(self):
        self.driver.seq_item_port.connect(self.sequencer.seq_item_export)
        default = self.registers.get_default_map()
        default.set_sequencer(self.sequencer, Adapter("adapter"))
        default.set_auto_predict(True)


class Status:
    """STATUS, field by field."""

    def __init__(self, word):
        self.busy, self.near_waits, self.fault = (word >> bit & 1 for bit in range(3))
        self.overfull, self.incomplete, self.clear, self.result = (
            word >> 3 & 3,
            word >> 5 & 3,
            word >> 7 & 1,
            word >> 8 & 7,
        )
        self.beyond_slow, self.beyond_warn, self.tag = word >> 11 & 1, word >> 12 & 1, word >> 24
        others = self.busy, self.near_waits, self.fault, self.incomplete, self.overfull, self.result
        assert not self.clear or others == (0, 0, 0, 0, 0, COMPLETE), f"clear, and else: {word:#x}"


class Registers(uvm_test):
    """What the tests have in common: a clock, a reset, a few steps on the registers."""

    def build_phase(self):
        self.environment = Environment("environment", self)

    async def run_phase(self):
        self.raise_objection()
        self.rng = np.random.default_rng(cocotb.RANDOM_SEED)
        self.top: Any = cocotb.top
        self.registers = self.environment.registers
        cocotb.start_soon(Clock(self.top.clk_i, 10, "ns").start())
        self.top.rst_ni.value = 0
        await ClockCycles(self.top.clk_i, 4)
        await FallingEdge(self.top.clk_i)
        self.top.rst_ni.value = 1
        self.registers.reset()
        built = {"M": 16, "Group": 8, "Certify": 1}
        built |= {name: int(value) for name, value in cocotb.plusargs.items() if str(value).isdecimal()}
        self.width, self.margin_bits, self.depth = (built[name] for name in ("W", "M", "Depth"))
        self.group = built["Group"]
        configuration = self.width | self.margin_bits << 6 | (self.depth.bit_length() - 1) << 12
        assert await self.read("CONFIGURATION") == configuration | built["Certify"] << 17
        await self.check()
        self.drop_objection()

    def register(self, name, index=None):
        found = getattr(self.registers, name)
        return found if index is None else found[index]

    async def read(self, name, index=None):
        status, value = await self.register(name, index).read()
        assert status == uvm_status_e.UVM_IS_OK
        return int(value)

    async def write(self, value, name, index=None):
        assert await self.register(name, index).write(int(value) & 0xFFFF_FFFF) == uvm_status_e.UVM_IS_OK

    async def load(self, mesh, triangles):
        await self.write(CLEAR | mesh, "LOAD")
        for triangle in triangles:
            for number, coordinate in enumerate(triangle.reshape(9)):
                await self.write(coordinate, "VERTEX", number)
            await self.write(mesh, "LOAD")

    async def begin(self, mode, move=(0, 0, 0), margin=0, trial=0, zones=(0, 0)):
        for axis, by in enumerate(move):
            await self.write(by, "MOVE", axis)
        for name, value in zip(MARGINS, (margin, *zones), strict=True):
            await self.write(value, name)
        await self.write(trial << 8 | mode, "RUN")

    async def counted(self):
        """Return the pairs of groups that were skipped and opened, the pairs that were skipped and tested."""
        names = ("GROUP_PAIRS_SKIPPED", "GROUP_PAIRS_OPENED", "PAIRS_SKIPPED", "TESTED")
        return [await self.read(name) for name in names]

    async def status(self):
        """Return the fields of STATUS."""
        return Status(await self.read("STATUS"))

    async def end(self):
        """Read near pairs until the run has ended; return them and its result."""
        found = []
        while True:
            status = await self.status()
            assert not (status.clear and (status.busy or found))
            assert status.clear or not (status.beyond_slow or status.beyond_warn)
            if status.near_waits:
                pair = await self.read("NEAR_PAIR")
                found.append((pair & 0xFFFF, pair >> 16))
            elif not status.busy:
                assert await self.read("NEAR_PAIR") == 0xFFFF_FFFF
                assert not status.clear or await self.read("NEAR") == 0
                return found, status.result

    async def partly(self, name, value, strobes):
        """Write some bytes of a word."""
        address = self.register(name).get_address()
        await self.environment.driver.axi.write(address, value, byte_enable=strobes)

    def triangles(self, count):
        """Return triangles of a size at which some of two meshes are near each other."""
        low, high = coordinate_range(self.width)
        size = max(2, (high - low) // 6)
        at = self.rng.integers(low // 2, high // 2, (count, 1, 3))
        return np.clip(at + self.rng.integers(-size, size + 1, (count, 3, 3)), low, high)

    def near(self, a, b, move, margin):
        """Return the near pairs of two meshes."""
        pairs = np.array([(one + move, other) for one in a for other in b], np.int64).reshape(-1, 2, 3, 3)
        near = bulk_facts(pairs, np.full(len(pairs), margin)).separating == 0
        return {divmod(int(number), len(b)) for number in np.flatnonzero(near)}

    def beyond(self, a, b, move, margin, slow, warn):
        """Return which zones, slow and warn, two meshes are beyond: of those wider than the one within."""
        return (
            slow > margin and not self.near(a, b, move, slow),
            warn > max(margin, slow) and not self.near(a, b, move, warn),
        )

    def signature(self, triangles):
        size = -(-self.width // 8)
        return zlib.crc32(
            b"".join(int(c).to_bytes(size, "little", signed=True) for c in triangles.reshape(-1))
        )

    async def check(self):
        raise NotImplementedError


@pyuvm.test(**LIMIT)
class SocRegistersTest(Registers):
    """Every register has the value and the access that its description says."""

    async def check(self):
        assert await self.read("IDENTITY") == 0x54524958
        names = {register.get_name() for register in self.registers.get_registers()}
        ours = {"CONFIGURATION", "STATUS", "NEAR_PAIR"}
        for name in sorted(names - ours):
            for register in np.atleast_1d(self.register(name)) if "[" not in name else ():
                if register.get_rights() != "WO":
                    status, value = await register.read()
                    assert (status, value) == (uvm_status_e.UVM_IS_OK, register.get_reset()), name
        kept = [("VERTEX", k) for k in range(9)] + [("MOVE", k) for k in range(3)]
        kept += [(name, None) for name in MARGINS]
        values = {place: int(self.rng.integers(0, 1 << 32)) for place in kept}
        for place, value in values.items():
            await self.write(value, *place)
        for place, value in values.items():
            assert await self.read(*place) == value == int(self.register(*place).get_mirrored_value()), place
        # What is read only stays as it is.
        for name in ("IDENTITY", "CONFIGURATION", "COUNT_A", "CYCLES"):
            before = await self.read(name)
            # The model would refuse it.
            await self.environment.driver.axi.write(self.register(name).get_address(), ~before & 0xFFFF_FFFF)
            assert await self.read(name) == before
        await self.write(0xFFFF_FFFF, "INTERRUPT_ENABLE")
        assert await self.read("INTERRUPT_ENABLE") == 15


@pyuvm.test(**LIMIT)
class SocScenesTest(Registers):
    """Runs over random meshes find the near pairs that there are, in every mode, and say so."""

    async def check(self):
        seen = 0
        for turn in range(6):
            a, b = (
                self.triangles(int(self.rng.integers(1, 17))),
                self.triangles(int(self.rng.integers(1, 17))),
            )
            await self.load(A, a)
            await self.load(B, b)
            assert [await self.read(name) for name in ("COUNT_A", "COUNT_B")] == [len(a), len(b)]
            signatures = [await self.read(name) for name in ("SIGNATURE_A", "SIGNATURE_B")]
            assert signatures == [self.signature(a), self.signature(b)]
            for mode in (MODE_ALL, MODE_FIRST, MODE_COUNT):
                low, high = coordinate_range(self.width)
                move = [
                    int(self.rng.integers(low - a[..., k].min(), high - a[..., k].max() + 1))
                    for k in range(3)
                ]
                move = [by // 8 for by in move] if turn % 2 else move
                margin, *zones = (int(m) // 2 for m in self.rng.integers(0, 1 << self.margin_bits, 3))
                due = self.near(a, b, move, margin)
                await self.write(DONE, "INTERRUPT")
                began = get_sim_time("ns")
                await self.begin(mode, move, margin, zones=zones)
                found, result = await self.end()
                clocks = (get_sim_time("ns") - began) / 10
                assert await self.read("INTERRUPT") & DONE
                said = f"{turn}: mode {mode}, move {move}, margin {margin}, zones {zones}"
                if mode == MODE_FIRST and due:
                    assert (result, len(found)) == (FIRST, 1) and set(found) <= due, said
                    continue
                assert result == COMPLETE and await self.read("NEAR") == len(due), said
                status = await self.status()
                assert status.clear == (not due), said
                told = status.beyond_slow, status.beyond_warn
                assert told == self.beyond(a, b, move, margin, *zones), said
                assert sorted(found) == (sorted(due) if mode != MODE_COUNT else []), said
                closed, opened, skipped, tested = await self.counted()
                assert closed + opened == -(-len(a) // self.group) * -(-len(b) // self.group), said
                assert opened <= skipped + tested <= min(opened * self.group**2, len(a) * len(b)), said
                assert len(due) <= tested < await self.read("CYCLES") < clocks, said
                seen += len(due)
        assert seen, "no near pair in any scene"
        # One group of B, its triangles far apart at one place of A's, between them, and beside them.
        await self.load(A, np.zeros((1, 3, 3), np.int64))
        await self.load(B, np.array([np.full((3, 3), by) for by in (-30, 30)]))
        between = (0, 1, 2, 0) if self.group > 1 else (2, 0, 0, 0)
        apart = (1, 0, 0, 0) if self.group > 1 else (2, 0, 0, 0)
        at = (0, 1, 1, 1) if self.group > 1 else (1, 1, 0, 1)
        for move, due in (((0, 0, 0), between), ((40, 0, 0), apart), ((30, 30, 30), at)):
            await self.begin(MODE_COUNT, move)
            await self.end()
            assert await self.counted() == list(due), move


@pyuvm.test(**LIMIT)
class SocZonesTest(Registers):
    """Zones are exact, in whatever order they are asked for, and change nothing of what is near."""

    async def check(self):
        told = set()
        largest = min((1 << self.margin_bits) - 1, 15)
        for _ in range(2):
            a, b = (self.rng.integers(-9, 10, (count, 3, 3)) for count in (4, 5))
            await self.load(A, a)
            await self.load(B, b)
            move, apart = (0, 0, 0), 0
            # So far apart that all zones around that distance can be asked for.
            while largest and not 2 < apart < largest:
                move = tuple(int(by) for by in self.rng.integers(-30, 31, 3))
                apart = next((m for m in range(largest + 1) if self.near(a, b, move, m)), 0)
            choices = sorted({0, max(apart - 2, 0), max(apart - 1, 0), apart, largest})
            for margin, slow, warn in product(choices, repeat=3):
                due = self.near(a, b, move, margin)
                mode = int(self.rng.choice((MODE_ALL, MODE_COUNT)))
                await self.begin(mode, move, margin, zones=(slow, warn))
                found, result = await self.end()
                status, near = await self.status(), await self.read("NEAR")
                said = f"mode {mode}, move {move}, margin {margin}, slow {slow}, warn {warn}"
                assert (result, near, status.clear) == (COMPLETE, len(due), not due), said
                assert sorted(found) == (sorted(due) if mode == MODE_ALL else []), said
                beyond = status.beyond_slow, status.beyond_warn
                assert beyond == self.beyond(a, b, move, margin, slow, warn), said
                told.add((bool(due), *beyond))
        if largest:
            clear = {(False, slow, warn) for slow in range(2) for warn in range(2)}
            assert told == {(True, 0, 0), *clear}, told


@pyuvm.test(**LIMIT)
class SocRefusalsTest(Registers):
    """What cannot be done is refused and told, and a run is not disturbed by it."""

    async def check(self):
        # Of an empty mesh nothing is clear: after a reset, and later.
        for mesh, count in ((None, 0), (A, 1), (B, 1), (A, 0)):
            if mesh is not None:
                await self.load(mesh, np.zeros((count, 3, 3), np.int64))
            held = await self.read("COUNT_A") and await self.read("COUNT_B")
            await self.begin(MODE_COUNT)
            assert (await self.end())[1] == (COMPLETE if held else NONE)
            assert not (await self.status()).clear
            assert await self.read("INTERRUPT") == (DONE if held else REFUSED)
            await self.write(REFUSED | DONE, "INTERRUPT")
        await self.write(DONE | FAULTED | REFUSED, "INTERRUPT_ENABLE")
        await self.load(A, np.zeros((16, 3, 3), np.int64))
        await self.load(B, np.zeros((15, 3, 3), np.int64))
        signature = await self.read("SIGNATURE_A")
        # All pairs are near: the run waits for its pairs to be read.
        await self.begin(MODE_ALL)
        assert not self.top.irq_o.value
        await self.write(NEAR_WAITS, "INTERRUPT_ENABLE")
        while not (await self.status()).near_waits:
            pass
        assert self.top.irq_o.value
        await self.write(NEAR_WAITS, "INTERRUPT")
        assert self.top.irq_o.value, "as long as a pair waits"
        await self.write(DONE | FAULTED | REFUSED, "INTERRUPT_ENABLE")
        for register, value in (("LOAD", A), ("LOAD", CLEAR | B), ("RUN", MODE_COUNT)):
            await self.write(REFUSED, "INTERRUPT")
            assert not self.top.irq_o.value
            await self.write(value, register)
            assert await self.read("INTERRUPT") == REFUSED | NEAR_WAITS and self.top.irq_o.value
        # Something that was wanted of it was not done, so its result is void.
        found, result = await self.end()
        assert result == NONE and len(found) == len(set(found)) == 240
        assert (await self.read("COUNT_A"), await self.read("COUNT_B")) == (16, 15)
        assert await self.read("SIGNATURE_A") == signature
        assert await self.read("INTERRUPT") == REFUSED | DONE | NEAR_WAITS
        # What they lack is missed by no run: they have to be emptied.
        assert (await self.status()).incomplete == 3
        await self.write(REFUSED | NEAR_WAITS, "INTERRUPT")
        await self.load(A, np.zeros((16, 3, 3), np.int64))
        assert (await self.status()).incomplete == 2
        await self.begin(MODE_COUNT)
        assert await self.end() == ([], NONE) and await self.read("INTERRUPT") == REFUSED | DONE
        await self.load(B, np.zeros((15, 3, 3), np.int64))
        await self.write(REFUSED, "INTERRUPT")
        assert await self.read("INTERRUPT") == DONE and self.top.irq_o.value
        await self.write(0, "INTERRUPT_ENABLE")
        assert not self.top.irq_o.value
        await self.begin(MODE_ALL)
        await self.write(1, "CONTROL")
        assert (await self.end())[1] == ABORTED
        await self.begin(MODE_NONE)
        assert await self.end() == ([], BAD_MODE)
        low, high = coordinate_range(self.width)
        for by in (low - 1, high + 1) if self.width < 32 else ():
            await self.begin(MODE_ALL, (0, by, 0))
            assert await self.end() == ([], OVERFLOW)
        for by in (low, high):
            await self.begin(MODE_COUNT, (0, 0, by))
            assert await self.end() == ([], COMPLETE)
            assert await self.read("NEAR") == 0
        # What is loaded is no part of that result; to load or ask for what does not fit ends it as well.
        await self.write(B, "LOAD")
        status = await self.status()
        assert (status.result, status.clear, status.incomplete) == (NONE, 0, 0)
        assert await self.read("COUNT_B") == 16
        await self.begin(MODE_COUNT)
        assert await self.end() == ([], COMPLETE)
        largest = (1 << self.margin_bits) - 1
        for place, right, wrong in [
            *(
                (("MOVE", axis), 0, by << sign)
                for axis in range(3)
                for by in (1, -1)
                for sign in (self.width + 1,)
            ),
            *((("VERTEX", k), 0, by) for k in range(9) for by in (low - 1, high + 1)),
            *(((name, None), 0, by) for name in MARGINS for by in (largest + 1, 1 << 31)),
        ]:
            if not -(1 << 31) <= wrong < (1 << 31) + (place[0] in MARGINS):
                continue
            await self.write(REFUSED, "INTERRUPT")
            before = [await self.read(name) for name in ("COUNT_B", "SIGNATURE_B", "CYCLES")]
            await self.write(wrong, *place)
            await self.write(*((B, "LOAD") if place[0] == "VERTEX" else (MODE_COUNT, "RUN")))
            assert await self.read("INTERRUPT") & REFUSED, (place, wrong)
            status = await self.status()
            assert (status.result, status.clear) == (NONE, 0)
            assert status.incomplete == (2 if place[0] == "VERTEX" else 0)
            assert [await self.read(name) for name in ("COUNT_B", "SIGNATURE_B", "CYCLES")] == before
            await self.write(right, *place)
            if place[0] == "VERTEX":
                await self.load(B, np.zeros((2, 3, 3), np.int64))
            await self.begin(MODE_COUNT)
            assert await self.end() == ([], COMPLETE)
        for name in MARGINS:
            await self.write(largest, name)
            await self.write(MODE_COUNT, "RUN")
            assert await self.end() == ([], COMPLETE)
        # A mesh is emptied whatever is in the registers.
        await self.write(high + 1 if self.width < 32 else 0, "VERTEX", 0)
        await self.write(REFUSED, "INTERRUPT")
        await self.write(CLEAR | B, "LOAD")
        assert not await self.read("INTERRUPT") & REFUSED and await self.read("COUNT_B") == 0
        await self.load(B, np.zeros((1, 3, 3), np.int64))
        await self.load(A, np.zeros((self.depth + 1, 3, 3), np.int64))
        assert (await self.status()).overfull == 1
        await self.begin(MODE_ALL)
        assert await self.end() == ([], OVERFULL)


@pyuvm.test(**LIMIT)
class SocFaultsTest(Registers):
    """A check that fails ends runs until that was acknowledged."""

    async def check(self):
        await self.write(FAULTED, "INTERRUPT_ENABLE")
        for mesh in (A, B):
            await self.load(mesh, np.zeros((1, 3, 3), np.int64))
        await self.begin(MODE_COUNT, trial=TRY_MEMORY)
        assert await self.end() == ([], FAULT)
        assert (await self.status()).fault and self.top.irq_o.value
        await self.write(FAULTED, "INTERRUPT")
        assert (await self.status()).fault and not self.top.irq_o.value
        await self.acknowledged()
        await self.begin(MODE_COUNT)
        assert await self.end() == ([], COMPLETE) and await self.read("NEAR") == 1
        # Apart, and clear, until the scrub that follows finds a mesh that is not as it was loaded.
        far = self.depth
        # However the reads lie to the clock in which the run ends, and to that of the fault.
        for offset in range(6):
            await self.begin(MODE_COUNT, (far, 0, 0), 0, TRY_SCRUB)
            await ClockCycles(self.top.clk_i, offset)
            status, tries = await self.status(), 0
            while not status.fault and tries < 20 + self.depth:
                status, tries = await self.status(), tries + 1
            assert status.fault and (status.result, status.clear) == (FAULT, 0)
            await self.acknowledged()
        await self.begin(MODE_COUNT, (far, 0, 0))
        assert await self.end() == ([], COMPLETE) and (await self.status()).clear

    async def acknowledged(self):
        """Acknowledge a fault: no run begins before both meshes were loaded anew."""
        await self.write(2, "CONTROL")
        status = await self.status()
        assert (status.fault, status.result, status.clear, status.incomplete) == (0, NONE, 0, 3)
        for mesh in (A, B):
            await self.write(REFUSED, "INTERRUPT")
            await self.begin(MODE_COUNT)
            assert (await self.end())[1] == NONE and await self.read("INTERRUPT") & REFUSED
            await self.load(mesh, np.zeros((1, 3, 3), np.int64))


@pyuvm.test(**LIMIT)
class SocBytesTest(Registers):
    """Parts of words do nothing by halves; what happens while INTERRUPT is written is not lost."""

    async def check(self):
        for mesh in (A, B):
            await self.load(mesh, np.zeros((1, 3, 3), np.int64))
        await self.begin(MODE_COUNT)
        assert await self.end() == ([], COMPLETE)
        # Of no byte: converters of buses do that.
        for name, value in (("LOAD", CLEAR | A), ("LOAD", A), ("RUN", MODE_NONE)):
            await self.partly(name, value, 0)
            status = await self.status()
            assert (status.result, status.incomplete, await self.read("INTERRUPT") & REFUSED) == (
                COMPLETE,
                0,
                0,
            )
        assert [await self.read(name) for name in ("COUNT_A", "COUNT_B", "NEAR")] == [1, 1, 1]
        for strobes in (1, 2, 7, 14):
            for name in ("LOAD", "RUN"):
                await self.write(REFUSED, "INTERRUPT")
                await self.partly(name, A, strobes)
                status = await self.status()
                assert (status.result, status.incomplete) == (NONE, 3 if name == "LOAD" else 0)
                assert await self.read("INTERRUPT") & REFUSED and await self.read("COUNT_A") == 1
                for mesh in (A, B):
                    await self.load(mesh, np.zeros((1, 3, 3), np.int64))
                await self.begin(MODE_COUNT)
                assert await self.end() == ([], COMPLETE)
        await self.partly("MARGIN", 0, 15)
        for offset in range(100):
            trial = TRY_MEMORY if offset % 2 else 0
            await self.write(DONE | FAULTED, "INTERRUPT")
            await self.write(trial << 8 | MODE_COUNT, "RUN")
            await ClockCycles(self.top.clk_i, offset // 2 + 1)
            await self.write(REFUSED, "INTERRUPT")
            while (await self.status()).busy:
                pass
            due = DONE | FAULTED if trial else DONE
            assert await self.read("INTERRUPT") & (DONE | FAULTED) == due, offset
            if trial:
                await self.write(2, "CONTROL")
                for mesh in (A, B):
                    await self.load(mesh, np.zeros((1, 3, 3), np.int64))


class Traffic:
    """Reads and writes by a master that waits for nothing: each channel goes at a pace of its own.

    The rules of AXI4-Lite are looked after: what is on offer stays until it is taken, nothing is held back
    until someone would take it, nothing is answered that was not asked.
    """

    def __init__(self, axi, clock, rng):
        self.bus, self.clock, self.rng = axi.bus, clock, rng
        self.writes, self.reads, self.seen = [], [], []
        self.taken: dict[str, int] = dict.fromkeys(("AW", "W", "B", "AR", "R"), 0)
        self.valid: dict[str, bool] = dict.fromkeys(self.taken, False)
        self.offered: dict[str, int | None] = {"B": None, "R": None}
        self.floors = []
        self.paces()

    def paces(self):
        """Choose how fast each channel goes from here on, and which of the answers are to come unasked."""
        self.pace = {name: float(self.rng.choice((0.1, 0.5, 1))) for name in self.taken}
        self.late = {name: bool(self.rng.integers(0, 2)) for name in ("B", "R")}

    async def step(self):
        """Go on by one clock."""
        await FallingEdge(self.clock)
        for name, queue in (("AW", self.writes), ("W", self.writes), ("AR", self.reads)):
            number = self.taken[name]
            if not self.valid[name] and number < len(queue) and self.rng.random() < self.pace[name]:
                self.valid[name] = True
                if name == "W":
                    self.bus.WDATA.value, self.bus.WSTRB.value = queue[number][1:]
                elif name == "AW":
                    self.bus.AWADDR.value = queue[number][0]
                else:
                    self.bus.ARADDR.value = queue[number]
                    self.floors.append(self.taken["B"])
            getattr(self.bus, f"{name}VALID").value = int(self.valid[name])
        ready = {}
        for name in ("B", "R"):
            waits = self.offered[name] is not None
            ready[name] = self.rng.random() < self.pace[name] and (waits or not self.late[name])
            getattr(self.bus, f"{name}READY").value = int(ready[name])
        await ReadOnly()
        for name in ("AW", "W", "AR"):
            if self.valid[name] and int(getattr(self.bus, f"{name}READY").value):
                self.valid[name] = False
                self.taken[name] += 1
        asked = {"B": min(self.taken["AW"], self.taken["W"]), "R": self.taken["AR"]}
        for name in ("B", "R"):
            offered = None
            if int(getattr(self.bus, f"{name}VALID").value):
                assert int(getattr(self.bus, f"{name}RESP").value) == 0
                offered = int(self.bus.RDATA.value) if name == "R" else 0
                assert self.taken[name] < asked[name], "answered before it was asked"
            kept = self.offered[name]
            assert kept is None or kept == offered, f"{name}: {kept}, then {offered}"
            if offered is not None and ready[name]:
                self.taken[name] += 1
                if name == "R":
                    number = len(self.seen)
                    self.seen.append((self.reads[number], offered, self.floors[number], asked["B"]))
                offered = None
            self.offered[name] = offered

    async def end(self):
        """Go on until all is answered."""
        for _ in range(200 * (1 + len(self.writes) + len(self.reads))):
            if self.taken["B"] == len(self.writes) and self.taken["R"] == len(self.reads):
                return
            await self.step()
        raise AssertionError("the bus is held up")

    async def read(self, address):
        """Read, whatever of the writes was answered."""
        self.reads.append(address)
        while len(self.seen) < len(self.reads):
            await self.step()
        return self.seen[-1][1]


class Meant:
    """What the meshes and the numbers are meant to be after each write: what a clear may be about."""

    def __init__(self, test):
        self.test = test
        self.at = {test.register(name).get_address(): name for name in ("LOAD", "RUN", *MARGINS)}
        self.at |= {0x20 + 4 * k: "VERTEX" for k in range(9)} | {0x44 + 4 * k: "MOVE" for k in range(3)}
        self.words = {address: 0 for address, name in self.at.items() if name not in ("LOAD", "RUN")}
        self.meshes, self.tag, self.run = ([], []), 0, None
        self.history: list[tuple[dict[Any, int], int, Any]] = [(dict(self.words), 0, None)]

    def signed(self, first, count):
        words = [self.words[first + 4 * k] for k in range(count)]
        return [word - (word >> 31 << 32) for word in words]

    def write(self, address, value, strobes=15):
        name = self.at.get(address, "")
        if address in self.words:
            mask = sum(255 << 8 * k for k in range(4) if strobes >> k & 1)
            self.words[address] = self.words[address] & ~mask | value & mask
        elif name == "LOAD" and strobes:
            self.run = None
            if value & CLEAR:
                self.meshes[value & 1].clear()
            else:
                self.meshes[value & 1].append(np.array(self.signed(0x20, 9)).reshape(3, 3))
        elif name == "RUN" and strobes:
            margins = [self.words[at] for at, name in self.at.items() if name in MARGINS]
            scene = (*(list(mesh) for mesh in self.meshes), self.signed(0x44, 3), *margins)
            self.tag, self.run = value >> 24, scene if strobes == 15 else None
        self.history.append((dict(self.words), self.tag, self.run))

    def clear(self, run):
        """Return whether a run is clear, and beyond slow and warn."""
        if run is None or not run[0] or not run[1]:
            return False, False, False
        a, b, move, margin, slow, warn = run
        low, high = coordinate_range(self.test.width)
        moved = np.array(a) + move
        most = (1 << self.test.margin_bits) - 1
        if moved.min() < low or moved.max() > high or max(margin, slow, warn) > most:
            return False, False, False
        if np.min([*a, *b]) < low or np.max([*a, *b]) > high or self.test.near(a, b, move, margin):
            return False, False, False
        return (True, *self.test.beyond(a, b, move, margin, slow, warn))


@pyuvm.test(**LIMIT)
class SocTrafficTest(Registers):
    """However the bus goes, a clear is of the run whose tag it has, and nothing was loaded since."""

    rounds = 12

    async def check(self):
        self.traffic = Traffic(self.environment.driver.axi, self.top.clk_i, self.rng)
        self.meant, self.checked, self.floor, self.clears, self.pairs = Meant(self), 0, 0, 0, 0
        names = ["STATUS", "INTERRUPT", "CONTROL", "LOAD", "RUN", "NEAR", "NEAR_PAIR", *MARGINS]
        names += [f"{name}_{mesh}" for name in ("COUNT", "SIGNATURE") for mesh in "AB"]
        self.address = {name: self.register(name).get_address() for name in names}
        stale = 0
        for turn in range(1, self.rounds + 1):
            self.traffic.paces()
            for _ in range(30):
                self.anything(turn)
            await self.traffic.end()
            self.look()
            await self.settled()
            stale += await self.scene(turn)
        assert stale and self.clears and self.pairs, "no read overtook a write, or nothing was clear, or near"
        await self.reset_amid()

    def put(self, address, value, strobes=15):
        value = int(value) & 0xFFFF_FFFF
        self.traffic.writes.append((address, value, strobes))
        self.meant.write(address, value, strobes)

    def anything(self, turn):
        """Ask for whatever may be asked for, whether or not it makes sense."""
        low, high = coordinate_range(self.width)
        drawn = int(self.rng.integers(low, high + 1)), int(self.rng.integers(-3, 4)), high + 1
        number = int(self.rng.choice(drawn))
        strobes = int(self.rng.choice((15, 15, 15, 0, 3, 8)))
        match int(self.rng.integers(0, 10)):
            case 0 | 1:
                self.put(int(self.rng.choice(list(self.meant.words))), number, strobes)
            case 2:
                self.put(self.address["LOAD"], self.rng.integers(0, 4), strobes)
            case 3 | 4:
                trial = int(self.rng.choice((0, 0, TRY_MEMORY, TRY_SCRUB)))
                self.put(self.address["RUN"], turn << 24 | trial << 8 | self.rng.integers(0, 4), strobes)
            case 5:
                place = self.address[str(self.rng.choice(("CONTROL", "INTERRUPT")))]
                self.put(place, self.rng.integers(0, 16), strobes)
            case 6:
                self.traffic.reads.append(int(self.rng.choice(list(self.meant.words))))
            case 7:
                self.traffic.reads.append(self.address["NEAR_PAIR"])
            case _:
                self.traffic.reads.append(self.address["STATUS"])

    def look(self):
        """Compare what was read with what was written, as far as it may have come by then."""
        for address, word, least, most in self.traffic.seen[self.checked :]:
            self.floor = max(self.floor, least)
            due = self.meant.history[self.floor : most + 1]
            if address in self.meant.words:
                fits = [words[address] == word for words, _, _ in due]
            elif address == self.address["STATUS"]:
                status = Status(word)
                told = bool(status.clear), bool(status.beyond_slow), bool(status.beyond_warn)
                self.clears += status.clear
                assert status.clear or told == (False, False, False)
                fits = [
                    tag == status.tag and (not status.clear or told == self.meant.clear(run))
                    for _, tag, run in due
                ]
            else:
                continue
            assert True in fits, f"{address:#x} is {word:#x}, after {self.floor} to {most} writes"
            self.floor += fits.index(True)
        self.checked = len(self.traffic.seen)

    async def settled(self):
        """End what goes on, and take back faults."""
        self.put(self.address["CONTROL"], 3)
        await self.traffic.end()
        while (status := Status(await self.traffic.read(self.address["STATUS"]))).busy or status.near_waits:
            await self.traffic.read(self.address["NEAR_PAIR"])
        self.put(self.address["CONTROL"], 2)
        self.put(self.address["INTERRUPT"], 15)
        await self.traffic.end()
        self.look()

    async def scene(self, turn):
        """Load and run without waiting for an answer; return whether a clear of before was read meanwhile."""
        meshes = []
        for mesh in (A, B):
            self.put(self.address["LOAD"], CLEAR | mesh)
            at = np.array(((60, 6, 0)[turn % 3] * (1 if mesh == A else -1), 0, 0))
            meshes.append(at + self.rng.integers(-9, 10, (int(self.rng.integers(1, 4)), 3, 3)))
            for triangle in meshes[mesh]:
                for number, coordinate in enumerate(triangle.reshape(9)):
                    self.put(0x20 + 4 * number, coordinate)
                self.put(self.address["LOAD"], mesh)
        margin, *zones = (int(m) for m in self.rng.integers(0, 1 << min(self.margin_bits, 6), 3))
        move = [int(by) for by in self.rng.integers(-2, 3, 3)]
        for axis, by in enumerate(move):
            self.put(0x44 + 4 * axis, by)
        for name, value in zip(MARGINS, (margin, *zones), strict=True):
            self.put(self.address[name], value)
        mode, found, stale = MODE_ALL if turn % 2 else MODE_COUNT, [], 0
        # Once more, of another tag: what is read before that is written is of the first.
        for tag in (128 | turn, 192 | turn):
            self.put(self.address["RUN"], tag << 24 | mode)
            if tag == 192 | turn:
                self.traffic.pace |= {"W": 0.1, "AR": 1}
            while (status := Status(await self.traffic.read(self.address["STATUS"]))).tag != tag:
                stale |= status.clear
            while status.busy:
                if status.near_waits:
                    pair = await self.traffic.read(self.address["NEAR_PAIR"])
                    found.append((pair & 0xFFFF, pair >> 16))
                status = Status(await self.traffic.read(self.address["STATUS"]))
            self.look()
            a, b = meshes
            due = self.near(a, b, move, margin)
            said = f"{turn}: mode {mode}, move {move}, margin {margin}, zones {zones}"
            assert (status.result, status.clear, status.incomplete) == (COMPLETE, not due, 0), said
            assert sorted(found) == (sorted(due) if mode == MODE_ALL else []), said
            (slow, warn), beyond = zones, (status.beyond_slow, status.beyond_warn)
            assert beyond == (self.beyond(a, b, move, margin, slow, warn) if status.clear else (0, 0)), said
            assert await self.traffic.read(self.address["NEAR"]) == len(due), said
            self.pairs += len(found)
            found.clear()
        for name, mesh in zip("AB", meshes, strict=True):
            assert await self.traffic.read(self.address[f"COUNT_{name}"]) == len(mesh)
            assert await self.traffic.read(self.address[f"SIGNATURE_{name}"]) == self.signature(mesh)
        assert await self.traffic.read(self.address["INTERRUPT"]) & ~NEAR_WAITS == DONE
        return stale

    async def reset_amid(self):
        """Reset while requests are under way: none is answered, and nothing that was loaded is left."""
        bus = self.traffic.bus
        for _ in range(8):
            self.put(self.address["RUN"], MODE_ALL)
            self.traffic.reads.append(self.address["STATUS"])
        for _ in range(20):
            await self.traffic.step()
        await FallingEdge(self.top.clk_i)
        self.top.rst_ni.value = 0
        for name in ("AW", "W", "AR"):
            getattr(bus, f"{name}VALID").value = 0
        for _ in range(3):
            await FallingEdge(self.top.clk_i)
            assert not int(bus.BVALID.value) and not int(bus.RVALID.value) and not int(self.top.irq_o.value)
        self.top.rst_ni.value = 1
        self.traffic = Traffic(self.environment.driver.axi, self.top.clk_i, self.rng)
        for name in ("STATUS", "COUNT_A", "COUNT_B", "NEAR", "INTERRUPT"):
            assert await self.traffic.read(self.address[name]) == 0, name
        self.traffic.writes.append((self.address["RUN"], MODE_COUNT, 15))
        await self.traffic.end()
        assert await self.traffic.read(self.address["INTERRUPT"]) == REFUSED
