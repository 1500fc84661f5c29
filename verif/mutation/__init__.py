"""Mutation: generated mutants of dut/ and the runs that kill them."""
