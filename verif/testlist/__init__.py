"""The UVM tests, chosen by name. cocotb loads this module in the simulator."""

from triaxis.verif.testlist.base_test import CoreTest
from triaxis.verif.testlist.tests import TESTS

__all__ = ["TESTS", "CoreTest"]
