"""Pin-level AXI4-Stream agents: one feeds pairs into the core, one takes its results."""
