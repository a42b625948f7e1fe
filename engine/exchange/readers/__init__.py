"""Materials of other programs as PBR maps: folders of textures, MaterialX and glTF."""
