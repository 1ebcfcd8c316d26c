"""What is believed: blocks, wiring as data, and the `Plant` and `Mechanism` made of them."""
