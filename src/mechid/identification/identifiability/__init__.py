"""What the records tell of each parameter: what none sees, what no record can tell, what depends on what."""
