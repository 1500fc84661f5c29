"""The UVM tests, chosen by name. cocotb loads `entry` in the simulator."""
