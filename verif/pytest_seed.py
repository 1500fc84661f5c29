"""For all tests: ``rng``, from ``--seed`` and the test's own name; no test of yosys runs without it.

What hypothesis draws follows from ``--seed``, too; how long it takes is no failure on a busy machine.
"""

import numpy as np
import pytest
from hypothesis import HealthCheck, settings

from triaxis.sim.programs import YOSYS, executable


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add ``--seed``."""
    parser.addoption("--seed", type=int, default=1, help="what all random choices follow from (1)")


# Before hypothesis's own plug-in, which takes its seed there.
@pytest.hookimpl(tryfirst=True)
def pytest_configure(config: pytest.Config) -> None:
    """Set up hypothesis."""
    settings.register_profile("triaxis", deadline=None, suppress_health_check=[HealthCheck.too_slow])
    settings.load_profile("triaxis")
    if config.option.hypothesis_seed is None:
        config.option.hypothesis_seed = config.getoption("--seed")


def pytest_report_header(config: pytest.Config) -> str:
    """Print the seed."""
    return f"seed: {config.getoption('--seed')} (repeat with --seed)"


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Skip what asks yosys where it is not installed: ``make setup`` alone leaves it out."""
    asks = item.get_closest_marker("prover") or item.get_closest_marker("synthesiser")
    if asks and not executable(YOSYS).exists():
        pytest.skip(f"{YOSYS} is not installed: `make formal` installs it")


@pytest.fixture
def seed(request: pytest.FixtureRequest) -> int:
    """Return the seed of the session."""
    value = request.config.getoption("--seed")
    assert isinstance(value, int)
    return value


@pytest.fixture
def rng(seed: int, request: pytest.FixtureRequest) -> np.random.Generator:
    """Return a generator of the test's own."""
    print(f"seed {seed}")
    return np.random.default_rng([seed, *request.node.nodeid.encode()])
