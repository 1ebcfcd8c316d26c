"""Parametric bootstrap: public function, numbers, document and figures."""
