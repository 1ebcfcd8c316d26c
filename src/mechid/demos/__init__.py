"""The demo: a synthetic bench, and its full identification."""
