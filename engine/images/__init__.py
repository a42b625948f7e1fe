"""Reading and writing pictures; pixels in, arrays out."""
