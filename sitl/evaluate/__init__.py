"""Two autopilots on the same water, judged from the plant's truth alone: `python -m sitl.evaluate`."""
