"""The stages of a scene, in the order in which `scene.step` runs them; each is a pure function."""
