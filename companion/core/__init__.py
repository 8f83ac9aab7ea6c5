"""Types, angles, frames and codecs that every room may use."""

from companion.core import types
from companion.core.records import quick

# The values of `types` that are made most often in a tick.
for _cls in (
    types.GnssFix, types.GroundVelocity, types.Heading, types.Imu, types.ThrusterFeedback, types.NavState, types.Status,
    types.ThrusterCommand, types.Setpoint, types.DeviceHealth, types.Inputs, types.Tick,
):  # fmt: skip
    quick(_cls)
