"""The environments, and the methods that use them, by which the design is signed off."""
