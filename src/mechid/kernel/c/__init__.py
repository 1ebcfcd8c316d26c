"""Translation of a kernel to C99: the same functions, parsed from the Python text and printed again."""
