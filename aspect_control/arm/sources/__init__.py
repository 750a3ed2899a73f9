"""What arms are made of, one format a file: URDF, the example robots, models of Pinocchio."""
