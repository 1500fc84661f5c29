"""Sequences of the engine: scenes are loaded by one agent and run by another."""

import cocotb
from pyuvm import uvm_sequence, uvm_sequencer

from triaxis.verif.mesh.items import LoadItem, RunItem, Scene
from triaxis.verif.testbench.environment import ItemsSequence


class SceneSequence(uvm_sequence):
    """A virtual sequence: loads a scene's meshes on the one agent, then asks the other for its runs.

    ``together``: where a scene asks for it, its first run is offered while B is still being loaded.
    """

    def __init__(
        self, scene: Scene, loads: uvm_sequencer, runs: uvm_sequencer, together: bool = False
    ) -> None:
        """Hold the scene and the sequencers."""
        super().__init__("scene")
        self.scene, self.loads, self.runs, self.together = scene, loads, runs, together
        self.asked: list[RunItem] = []

    async def body(self) -> None:
        """Load, then run."""
        scene = self.scene
        meshes = [(mesh, t) for mesh, t in enumerate((scene.a, scene.b)) if t is not None]
        loads = [LoadItem(mesh, triangles, scene.gaps) for mesh, triangles in meshes]
        self.asked = [RunItem(request, traffic) for request, traffic in scene.runs]
        early = loads[-1:] if scene.early and self.together else []
        await ItemsSequence(loads[: len(loads) - len(early)]).start(self.loads)
        loading = cocotb.start_soon(ItemsSequence(early).start(self.loads))
        await ItemsSequence(self.asked).start(self.runs)
        await loading
