"""What touches the disk: atomic writing, guarded reading, bundles."""
