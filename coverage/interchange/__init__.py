"""Coverage for other tools: lcov tracefiles, UCIS XML and ReqIF."""
