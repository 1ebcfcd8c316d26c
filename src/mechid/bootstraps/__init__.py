"""A bootstrap: the public function, its numbers, its document and figures."""
