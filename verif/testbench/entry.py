"""What cocotb loads in the simulator: the one test that the settings name.

Registering a test costs a tenth of a second each (pyuvm inspects the whole stack), so only the one
that runs is registered, here and not where it is defined.
"""

import pyuvm

from triaxis.verif.testbench.settings import from_environment

_SETTINGS = from_environment()
# Only what is needed: each import is a part of every run.
if _SETTINGS.of_mesh_engine:
    from triaxis.verif.mesh import sabotage_tests, uvm_tests

    _MODULES = (uvm_tests, sabotage_tests)
else:
    from triaxis.verif.core import bench_tests, sabotage_tests, uvm_tests
    from triaxis.verif.faults import fault_tests

    _MODULES = (uvm_tests, bench_tests, sabotage_tests, fault_tests)
_FOUND = [vars(module)[_SETTINGS.test] for module in _MODULES if _SETTINGS.test in vars(module)]

SELECTED = pyuvm.test()(_FOUND[0])
