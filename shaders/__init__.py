"""The GLSL 330 sources of shadowatmo, read by `shadowatmo.passes.gl.shader`."""
