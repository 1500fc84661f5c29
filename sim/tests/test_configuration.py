import pytest

from triaxis.golden.errors import InputError
from triaxis.sim.configuration import Configuration, parse_configuration


@pytest.mark.parametrize(
    "configuration",
    [
        Configuration(),
        Configuration(32, 32, 1),
        Configuration(16, 0, edge_box=False),
        Configuration(8, 0, 3, edge_box=False, gating=False),
    ],
)
def test_names_are_unique_and_parse(configuration):
    assert parse_configuration(configuration.name) == configuration


@pytest.mark.parametrize(
    "name", ["", "w16", "w16_m", "w7_m0", "w33_m0", "w16_m17", "w16_m1_no_edge_box", "x"]
)
def test_bad_names(name):
    with pytest.raises(InputError):
        parse_configuration(name)
