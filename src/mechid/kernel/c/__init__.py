"""A kernel's text in C99: the same functions, read from the Python text and printed anew."""
