"""The UVM tests, chosen by name. cocotb loads `tests` in the simulator."""
