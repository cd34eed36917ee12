"""OpenGL plumbing: context, shader loader, textures, state guard and raw entry points."""
