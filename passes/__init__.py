"""What draws: one file per pass, and the OpenGL plumbing in `gl`."""
