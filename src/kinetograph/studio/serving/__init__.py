"""The port: files and socket, and who is let in."""
