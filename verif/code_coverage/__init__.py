"""Code coverage of the RTL: builds with counters, and what is played on them."""
