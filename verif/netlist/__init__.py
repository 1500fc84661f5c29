"""The netlist: the synthesised design under the tests of the RTL, and proved equal to it module by module."""
