"""Six-component benches made by a simulator of its own, and what `mechid emission` makes of them."""
