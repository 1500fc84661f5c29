"""What cocotb loads in the simulator: the one test that the settings name.

Registering a test costs a tenth of a second each (pyuvm inspects the whole stack), so only the one
that runs is registered, here and not where it is defined.
"""

import pyuvm

from triaxis.verif.settings import from_environment
from triaxis.verif.testlist import tests

SELECTED = pyuvm.test()(getattr(tests, from_environment().test))
