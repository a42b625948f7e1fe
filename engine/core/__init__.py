"""The base of all rooms: errors, long work in steps, declared parameters, health, colour and directions."""
