METRICS = {"end": float, "peak_torque": float}
