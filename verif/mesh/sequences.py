"""Sequences of the engine: scenes are loaded by one agent and run by another."""

from itertools import pairwise

import cocotb
from cocotb.triggers import Event
from pyuvm import uvm_sequence, uvm_sequencer

from triaxis.verif.mesh.items import LoadItem, RunItem, Scene
from triaxis.verif.testbench.environment import ItemsSequence


class SceneSequence(uvm_sequence):
    """A virtual sequence: loads a scene's meshes on the one agent, then asks the other for its runs.

    ``loads`` and ``runs`` are its items; ``loaded`` is set once its meshes are there.
    """

    def __init__(self, scene: Scene, load_sequencer: uvm_sequencer, run_sequencer: uvm_sequencer) -> None:
        """Hold the scene and the sequencers."""
        super().__init__("scene")
        self.scene, self.load_sequencer, self.run_sequencer = scene, load_sequencer, run_sequencer
        meshes = [(mesh, t) for mesh, t in enumerate((scene.a, scene.b)) if t is not None]
        self.loads = [LoadItem(mesh, t, scene.gaps, not scene.append) for mesh, t in meshes]
        self.runs = [RunItem(request, traffic) for request, traffic in scene.runs]
        if scene.chained:
            for run, following in pairwise(self.runs):
                run.following = following
        self.loaded = Event()

    async def body(self) -> None:
        """Load, then run."""
        early = self.loads[-1:] if self.scene.early else []
        await ItemsSequence(self.loads[: len(self.loads) - len(early)]).start(self.load_sequencer)
        loading = cocotb.start_soon(ItemsSequence(early).start(self.load_sequencer))
        if not early:
            self.loaded.set()
        # Those that follow another one come with it.
        await ItemsSequence(self.runs[:1] if self.scene.chained else self.runs).start(self.run_sequencer)
        await loading
        self.loaded.set()
