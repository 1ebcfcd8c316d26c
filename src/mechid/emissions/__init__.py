"""Emission at the interface against its specification: the public function and all that is shown of its result."""
