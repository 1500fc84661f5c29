"""Which width suits real meshes: resolution, false alarms, DSP blocks and time of each."""
