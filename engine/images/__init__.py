"""Images in and out: EXR, HDR, JPEG, PNG and TIFF, decoded to linear light in another process."""
