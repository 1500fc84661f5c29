"""The core in a cocotb test of its own: one pair, asked at two margins.

A triangle in the plane z = 0, and another in z = 3 above it: near at the margin 3, clear at 2. W = 16, M = 4,
TAG = 8, as in first_pair.sv.
"""

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, RisingEdge

W, M = 16, 4
PAIR = [(0, 0, 0), (9, 0, 0), (0, 9, 0), (1, 1, 3), (4, 1, 3), (1, 4, 3)]


@cocotb.test()
async def first_pair(dut) -> None:
    """Send the pair twice; its verdict comes with its tag."""
    cocotb.start_soon(Clock(dut.clk_i, 10, "ns").start())
    dut.rst_ni.value, dut.s_axis_tvalid_i.value, dut.m_axis_tready_i.value = 0, 0, 1
    for _ in range(4):
        await FallingEdge(dut.clk_i)
    dut.rst_ni.value = 1
    coordinates = [c for vertex in PAIR for c in vertex]
    # x of A1 in the lowest bits.
    dut.s_axis_tdata_i.value = sum((c % 2**W) << (W * k) for k, c in enumerate(coordinates))
    for margin, near in ((2, False), (3, True)):
        await FallingEdge(dut.clk_i)
        dut.s_axis_tuser_i.value, dut.s_axis_tvalid_i.value = margin << M | margin, 1
        await RisingEdge(dut.clk_i)
        while not dut.s_axis_tready_o.value:
            await RisingEdge(dut.clk_i)
        await FallingEdge(dut.clk_i)
        dut.s_axis_tvalid_i.value = 0
        await RisingEdge(dut.clk_i)
        while not dut.m_axis_tvalid_o.value:
            await RisingEdge(dut.clk_i)
        verdict = int(dut.m_axis_tdata_o.value)
        cocotb.log.info("margin %d: %s", int(dut.m_axis_tuser_o.value), "near" if verdict & 1 else "clear")
        assert int(dut.m_axis_tuser_o.value) == margin and bool(verdict & 1) == near
