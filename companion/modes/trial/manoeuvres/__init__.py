"""The manoeuvres of a trial: one file each, in the order of `companion.modes.trial.programme`."""
