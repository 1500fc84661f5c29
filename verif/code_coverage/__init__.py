"""Code coverage of the RTL: builds with counters, and the tests that run on them."""
