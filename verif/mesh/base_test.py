"""What all tests of the engine share: its environment, scenes, and the end of the test."""

from triaxis.verif.mesh.burst_agents import MeshBfm, use_bursts
from triaxis.verif.mesh.env import MeshEnv
from triaxis.verif.mesh.items import Scene
from triaxis.verif.mesh.sequences import SceneSequence
from triaxis.verif.mesh.shapes import Shapes
from triaxis.verif.testbench.environment import EnvironmentTest, create
from triaxis.verif.testbench.failures import HOPELESS

# Clocks after the last summary in which anything too many would show.
_SURPLUS_CYCLES = 64


class MeshEngineTest(EnvironmentTest):
    """Resets the engine and runs `stimulus`."""

    outputs = {  # noqa: RUF012 (never changed)
        **dict.fromkeys(
            (
                "s_axis_load_tready_o", "count_a_o", "count_b_o", "overfull_o", "signature_a_o",
                "signature_b_o", "s_axis_run_tready_o",
                "busy_o", "m_axis_near_tvalid_o", "m_axis_done_tvalid_o", "fault_o",
            )
        ),
        "m_axis_near_tdata_o": "m_axis_near_tvalid_o",
        **dict.fromkeys(
            (
                "status_o", "cycles_o", "group_pairs_skipped_o", "group_pairs_opened_o", "pairs_skipped_o",
                "tested_o", "near_o", "zones_o",
            ),
            "m_axis_done_tvalid_o",
        ),
    }  # fmt: skip

    def build_phase(self) -> None:
        """Make the environment."""
        super().build_phase()
        self.configuration = self.settings.mesh_configuration
        self.shapes = Shapes(self.rng, self.configuration)
        self.env = create(MeshEnv, "env", self)

    def fast_model(self) -> MeshBfm:
        """Return the engine's model."""
        use_bursts()
        return MeshBfm()

    async def traffic(self) -> None:
        """Run `stimulus`; a summary too many would show after it."""
        await self.stimulus()
        await self.clocks(_SURPLUS_CYCLES)
        scoreboard, env = self.env.scoreboard, self.env
        scoreboard.runs_sent, scoreboard.triangles_sent = env.run_agent.driver.sent, env.load.driver.sent
        scoreboard.resets_sent = self.resets

    async def send(self, scene: Scene) -> SceneSequence:
        """Load a scene and run its runs; return what was sent."""
        sequence = self.sequence(scene)
        await sequence.start()
        return sequence

    def sequence(self, scene: Scene) -> SceneSequence:
        """Return the sequence of a scene, to be started."""
        return SceneSequence(scene, self.env.load.sequencer, self.env.run_agent.sequencer)

    @property
    def unfinished(self) -> bool:
        """Return whether fewer pairs were accounted for than the test was asked for, and may still be."""
        scoreboard = self.env.scoreboard
        return scoreboard.checker.pairs < self.settings.pairs and scoreboard.failed < HOPELESS
