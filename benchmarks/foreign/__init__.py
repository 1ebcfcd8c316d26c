"""Benches made by other people's simulators: heyoka (Taylor series with events) and ngspice (a driver's circuit)."""
