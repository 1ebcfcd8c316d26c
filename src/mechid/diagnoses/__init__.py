"""Diagnosis of a finished fit: public function, numbers, document and figures."""
