"""The three controls: each a frozen configuration that is fitted to a library and answers controls."""
