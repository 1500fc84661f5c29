"""Programs of moves, and whether a tool stays clear of what it moves past."""
