"""The base of all packages: errors, long work in steps, declared parameters, health, colour and directions."""
