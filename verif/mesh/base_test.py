"""What all tests of the engine share: clock, reset, environment, the end of the test."""

import faulthandler
import signal
from pathlib import Path
from typing import Any

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge, Timer
from pyuvm import uvm_report_server, uvm_test

from triaxis.sim.clocking import PERIOD_NS
from triaxis.sim.mesh_engine import MeshEngine
from triaxis.verif.mesh.bare_agents import use_bare_engine
from triaxis.verif.mesh.bare_bfm import BareBfm
from triaxis.verif.mesh.env import MeshEnv
from triaxis.verif.mesh.handles import publish_bare
from triaxis.verif.mesh.items import RunItem, Scene
from triaxis.verif.mesh.sequences import SceneSequence
from triaxis.verif.mesh.shapes import Shapes
from triaxis.verif.testbench.handles import create, publish
from triaxis.verif.testbench.settings import PIN, dut_from_environment, from_environment

_RESET_CYCLES = 3
# Clocks after the last summary in which anything too many would show.
_SURPLUS_CYCLES = 64


class MeshEngineTest(uvm_test):
    """Resets the engine and runs `stimulus`. Tests override `stimulus`."""

    def build_phase(self) -> None:
        """Take the settings from the runner and make the environment."""
        self.dut: Any = cocotb.top
        self.settings = from_environment()
        self.configuration = self.settings.mesh_configuration
        # A generator of the test's own name, so that tests of one seed differ.
        self.rng = np.random.default_rng([self.settings.seed, *type(self).__name__.encode()])
        self.shapes = Shapes(self.rng, self.configuration)
        self.on_pins = self.settings.agent == PIN
        publish(self.settings, self.dut, None)
        publish_bare(
            None if self.on_pins else BareBfm(MeshEngine(self.configuration, dut_from_environment()))
        )
        if not self.on_pins:
            use_bare_engine()
        Path(self.settings.folder).mkdir(parents=True, exist_ok=True)
        self.env = create(MeshEnv, "env", self)

    async def run_phase(self) -> None:
        """Run the test."""
        self.raise_objection()
        # The solver's handler of interrupts would jump out of the simulator.
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        # Whatever else happens, no run lasts for ever.
        faulthandler.dump_traceback_later(self.settings.time_limit, exit=True)
        if self.on_pins:
            Clock(self.dut.clk_i, PERIOD_NS, "ns").start()
            await self.between_edges()
            await self.reset(_RESET_CYCLES)
        await self.stimulus()
        await self.clocks(_SURPLUS_CYCLES)
        board, env = self.env.scoreboard, self.env
        board.runs_sent, board.triangles_sent = env.run_agent.driver.sent, env.load.driver.sent
        self.drop_objection()

    def check_phase(self) -> None:
        """Fail where anything reported an error, even if nothing else noticed."""
        uvm_report_server.get().assert_no_failures()

    async def stimulus(self) -> None:
        """Send what the test is about."""
        raise NotImplementedError

    async def send(self, scene: Scene) -> list[RunItem]:
        """Load a scene and run its runs; return the runs' items."""
        loads, runs = self.env.load.sequencer, self.env.run_agent.sequencer
        sequence = SceneSequence(scene, loads, runs, self.on_pins)
        await sequence.start()
        return sequence.asked

    @property
    def unfinished(self) -> bool:
        """Return whether fewer pairs were accounted for than the test was asked for."""
        return self.env.scoreboard.checker.pairs < self.settings.pairs

    async def clocks(self, count: int) -> None:
        """Wait for some clocks."""
        await Timer(count * PERIOD_NS, "ns")

    async def between_edges(self) -> None:
        """Wait until a little after an edge: what happens between clocks must not happen at one."""
        await RisingEdge(self.dut.clk_i)
        await Timer(1, "ns")

    async def reset(self, cycles: int, late_ns: int = 0) -> None:
        """Hold the engine in reset for some clocks, from some time after the edge on."""
        if late_ns:
            await Timer(late_ns, "ns")
        self.dut.rst_ni.value = 0
        await Timer(cycles * PERIOD_NS - late_ns, "ns")
        self.dut.rst_ni.value = 1
        await self.clocks(1)
