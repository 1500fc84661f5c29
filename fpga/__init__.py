"""What no simulation sees: synthesis, timing, the bitstream, registers behind a bus, packages of the RTL."""
