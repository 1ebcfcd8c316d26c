"""Check of a campaign: public function and presentation of its result."""
