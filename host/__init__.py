"""What a machine builder uses: meshes, poses, checks, paths, the board, advice, the command line."""
