# The flow makefile that dvsim calls: one target for a build, one for a run. dvsim hands everything in.
.PHONY: build run

build:
	mkdir -p $(build_dir)
	$(build_cmd) $(build_opts)

run:
	mkdir -p $(run_dir)
	$(run_cmd) $(run_opts)
