"""Survey of records before any model: the public function and the presentation of its result."""
