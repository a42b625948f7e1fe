"""The surface behind the photographs: normals, height and PBR maps, with their uncertainty."""
