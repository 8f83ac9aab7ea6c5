"""Action files for QGroundControl, for its fly view and for joystick buttons."""
