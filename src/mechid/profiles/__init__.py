"""Likelihood profiles: public function, numbers, document and figures."""
