"""What cocotb loads in the simulator: the one test that the settings name."""

from importlib import import_module

import cocotb
from pyuvm import uvm_root

from triaxis.verif.testbench.reports import reporting
from triaxis.verif.testbench.settings import BOARD_TESTS, CORE_TESTS, MESH_TESTS, Block, from_environment
from triaxis.verif.testbench.trials import concluding_trial, next_test

_SETTINGS = from_environment()
# By name: the tests' modules import this package, which must not import them. The last ones are only looked
# through for a test that the first do not have: what plays mutants imports nothing that no hash knows.
_NAMES = {
    Block.CORE: (*CORE_TESTS, "triaxis.verif.core.sabotage_tests", "triaxis.verif.faults.fault_tests"),
    Block.MESH: (*MESH_TESTS, "triaxis.verif.mesh.sabotage_tests"),
    Block.BOARD: (*BOARD_TESTS, "triaxis.verif.board.sabotage_tests", "triaxis.verif.upsets.upset_test"),
}[_SETTINGS.block]
# Before trials fork, which then need not import it each: where the tests stand that try mutants.
for _name in BOARD_TESTS if _SETTINGS.block is Block.BOARD else _NAMES[:1]:
    import_module(_name)
_NAME = next_test(_SETTINGS).test


# Not by pyuvm's decorator, which inspects the whole stack: a tenth of a second.
@cocotb.test(name=_NAME)
async def selected(_: object) -> None:
    """Run the test."""
    modules = (import_module(name) for name in _NAMES)
    test = next(vars(module)[_NAME] for module in modules if _NAME in vars(module))
    with concluding_trial(), reporting(_SETTINGS):
        await uvm_root().run_test(test)
