"""An identified mechanism as C99 text: files, their compilation, and their comparison with the kernel."""
