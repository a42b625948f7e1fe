"""Many captures in one run: found, made side by side in processes of their own, recorded, and reported."""
