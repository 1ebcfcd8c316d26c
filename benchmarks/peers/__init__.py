"""The programs that the benchmarks measure side by side, one module each."""
