"""Records that contradict the others or their declaration: what they may be instead, and where a model leaves them."""
