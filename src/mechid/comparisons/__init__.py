"""Comparison of fits of the same records: public function, numbers, document and figures."""
