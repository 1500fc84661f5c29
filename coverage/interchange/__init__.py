"""Coverage for other tools: lcov tracefiles and UCIS XML."""
