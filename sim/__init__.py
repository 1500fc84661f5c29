"""Every way in which the RTL becomes something that runs: configurations, builds, bindings, players."""
