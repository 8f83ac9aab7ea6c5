"""The companion as a BlueOS extension, with actions and joystick suggestions for Cockpit. Not tried on a BlueOS; see
README.md here."""
