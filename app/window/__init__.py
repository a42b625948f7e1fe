"""The window itself: workspaces, docks, menus, and how a failure reaches the user."""
