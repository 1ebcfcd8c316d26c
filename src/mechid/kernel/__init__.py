"""A plant becomes generated source, a compiled `Kernel`, and its slow twin."""
