"""Finished fits that the functions begin from: in memory, or read from a result folder with their campaign."""
