"""What cocotb loads in the simulator: the one test that the settings name.

Registering a test costs a tenth of a second each (pyuvm inspects the whole stack), so only the one
that runs is registered, here and not where it is defined.
"""

import pyuvm

from triaxis.verif.faults import uvm_tests
from triaxis.verif.settings import from_environment
from triaxis.verif.testlist import bench_tests, sabotage_tests, tests

_NAME = from_environment().test
_MODULES = (tests, bench_tests, sabotage_tests, uvm_tests)
_FOUND = [vars(module)[_NAME] for module in _MODULES if _NAME in vars(module)]

SELECTED = pyuvm.test()(_FOUND[0])
