"""Generator of the campaigns and of their answers: the simulator of the incomplete benches, nothing of mechid."""
