"""Runs a kernel over a record's time base: `Simulator` makes a `Trajectory`."""
