"""The photographs of a capture and where the lamp stood in each: names, lists, mirror spheres."""
