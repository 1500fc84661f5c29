"""The environment of the mesh engine: whole scenes, driven and checked."""
