"""Materials as other programs take them, each with the error of what it leaves out."""
