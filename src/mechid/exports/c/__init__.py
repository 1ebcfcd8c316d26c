"""Export as C99 source: files, their compilation, and their comparison with the kernel."""
