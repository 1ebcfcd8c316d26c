"""Fits of the same records compared: the public function, their numbers, their document and figures."""
