"""The project file: everything a user chose and did, on disk at any moment, and what was made of it beside it."""
