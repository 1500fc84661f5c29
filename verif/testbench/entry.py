"""What cocotb loads in the simulator: the one test that the settings name.

Registering a test costs a tenth of a second each (pyuvm inspects the whole stack), so only the one
that runs is registered, here and not where it is defined.
"""

from importlib import import_module

import pyuvm

from triaxis.verif.testbench.settings import CORE_TESTS, MESH_TESTS, from_environment

_SETTINGS = from_environment()
# By name: the tests' modules import this package, which must not import them. And only those that are needed:
# each import takes time.
_OF_MESH_ENGINE = (MESH_TESTS, "triaxis.verif.mesh.sabotage_tests")
_OF_CORE = (CORE_TESTS, "triaxis.verif.core.sabotage_tests", "triaxis.verif.faults.fault_tests")
_NAMES = _OF_MESH_ENGINE if _SETTINGS.of_mesh_engine else _OF_CORE
_MODULES = [import_module(name) for name in _NAMES]
_FOUND = [vars(module)[_SETTINGS.test] for module in _MODULES if _SETTINGS.test in vars(module)]

SELECTED = pyuvm.test()(_FOUND[0])
