"""The 3D view: a figure that moves in a viser scene, and the proxy that decides who may see it."""
