"""Sample recordings and characters, fetched once."""
