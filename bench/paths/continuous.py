"""Packages for continuous motion: does a tool that moves straight touch what stands still?"""

from functools import partial
from typing import Any

import numpy as np

from triaxis.bench.peers.peer import Peer, Question, Reals, imported, installed_version
from triaxis.bench.peers.wheels import fcl_model


def _numbered(facets: Reals) -> tuple[Reals, Any]:
    """Return vertices, each once, and their numbers (N, 3)."""
    vertices, numbers = np.unique(facets.reshape(-1, 3), axis=0, return_inverse=True)
    return vertices.astype(np.float64), numbers.reshape(-1, 3)


def _fcl_motion(moves: Reals, tool: Reals, work: Reals) -> Question:
    fcl = imported("fcl")
    first, second, still = fcl_model(tool), fcl_model(work), fcl.Transform()

    def ask() -> Any:
        found: list[bool] = []
        for start, end in moves:
            first.setTransform(fcl.Transform(start))
            request, result = fcl.ContinuousCollisionRequest(), fcl.ContinuousCollisionResult()
            found.append(fcl.continuousCollide(first, fcl.Transform(end), second, still, request, result) < 1)
        return np.array(found)

    return Question(ask)


def _ipc_motion(moves: Reals, tool: Reals, work: Reals) -> Question:
    ipctk = imported("ipctk")
    (tool_at, tool_faces), (work_at, work_faces) = _numbered(tool), _numbered(work)
    faces = np.concatenate([tool_faces, work_faces + len(tool_at)]).astype(np.int32)
    both = np.concatenate([tool_at, work_at])
    mesh = ipctk.CollisionMesh(both, ipctk.edges(faces), faces)

    def ask() -> Any:
        found: list[bool] = []
        for start, end in moves:
            here, there = both.copy(), both.copy()
            here[: len(tool_at)] += start
            there[: len(tool_at)] += end
            found.append(not ipctk.is_step_collision_free(mesh, here, there))
        return np.array(found)

    return Question(ask)


def peers(moves: Reals) -> tuple[Peer, ...]:
    """Return the packages that are asked about these moves."""
    return (
        Peer("FCL, python-fcl", "python-fcl", "fcl.continuousCollide(BVHModel, BVHModel)",
             partial(installed_version, "python-fcl", "fcl"), partial(_fcl_motion, moves)),
        Peer("IPC Toolkit, ipctk", "ipctk", "ipctk.is_step_collision_free(mesh, V0, V1)",
             partial(installed_version, "ipctk", "ipctk"), partial(_ipc_motion, moves)),
    )  # fmt: skip
