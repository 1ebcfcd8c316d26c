"""Diagnosis of a finished fit: the public function, its numbers, its document and figures."""
