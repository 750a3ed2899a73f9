"""Many runs: the studies made with the laws, from the paper's own case to random motions of any robot."""
