"""Demo: a synthetic bench with its full identification."""
