"""A capture that is being taken: followed in its folder, taken from a camera on a cable, and made a project."""
