"""Profiles of the likelihood: the public function, their numbers, their document and figures."""
