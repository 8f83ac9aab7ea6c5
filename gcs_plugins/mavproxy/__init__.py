"""A module for MAVProxy: `--load-module=gcs_plugins.mavproxy.mavproxy_usv`."""
