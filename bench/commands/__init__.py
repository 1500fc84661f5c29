"""Commands of the benchmarks: nothing of them imports these."""
