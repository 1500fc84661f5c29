"""The one thread beside the simulation, in the simulator's process: it makes stimulus and checks results.

One and not several: between two such threads Python's lock would change hands at every array operation,
which costs more than it brings. The simulation itself runs without the lock.
"""

from concurrent.futures import ThreadPoolExecutor

WORKER = ThreadPoolExecutor(1, "worker")
