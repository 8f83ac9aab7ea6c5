/* The wiring of this board. Edit only this file. It comes as ReVolt's bow and one stern pod on an Arduino Mega. */
#ifndef BOARD_CONFIG_H
#define BOARD_CONFIG_H

#include "usv_board.h"
#include "usv_rc.h"

#define BOARD_NAME "revolt"
#define HOST Serial
#define HOST_BAUD 115200

#define NO_PIN 255

/* Order and number of thrusters are those of `thrusters` in the vessel's file. */
#define THRUSTER_COUNT 2
#define RELAY_COUNT 1
#define SERVO_COUNT 1

static const usv_drive_config THRUSTERS[THRUSTER_COUNT] = {
    {
        /* trim, ahead, astern, dead_us, reversed, rate_per_s */
        1500, 1900, 1100, 20, false, 20000,
        /* azimuth: kind, rest, min, max (1e-4 rad), min_us, max_us, rate (1e-4 rad/s) */
        USV_WITH_STOPS, 0, -27000, 27000, 1000, 2000, 26180,
        /* travel_ms, end_switches; per cent of surge, sway and yaw stick in safe mode, azimuth at full yaw stick */
        0, false, 100, 0, 0, 7854,
    },
    {
        1500, 1900, 1100, 20, false, 20000,
        USV_FIXED, 15708, 0, 0, 0, 0, 0,
        5000, true, 0, 100, 30, 0,
    },
};

/* USV_SAFE_NOTHING: only the companion reads the switch. USV_SAFE_CUT: it cuts thrust here. USV_SAFE_STICKS: it gives the sticks the
 * thrusters here, ALSO WHILE THE COMPANION IS DISARMED OR OFF. */
static const usv_board_config CONFIG = {BOARD_NAME, THRUSTER_COUNT, RELAY_COUNT, SERVO_COUNT, THRUSTERS, USV_SAFE_CUT, 5, 3, 1, 4};

/* One of each per thruster. Lower and raise drive the two inputs of an H-bridge. */
static const uint8_t THROTTLE_PIN[THRUSTER_COUNT] = {5, 6};
static const uint8_t AZIMUTH_PIN[THRUSTER_COUNT] = {7, NO_PIN};
static const uint8_t LOWER_PIN[THRUSTER_COUNT] = {NO_PIN, 22};
static const uint8_t RAISE_PIN[THRUSTER_COUNT] = {NO_PIN, 23};
static const uint8_t UP_SWITCH_PIN[THRUSTER_COUNT] = {NO_PIN, 24}; /* to ground when there */
static const uint8_t DOWN_SWITCH_PIN[THRUSTER_COUNT] = {NO_PIN, 25};

static const uint8_t RELAY_PIN[] = {26};
static const uint8_t SERVO_PIN[] = {8};
static const uint8_t RED_PIN = 30, YELLOW_PIN = 31, GREEN_PIN = 32;

static const uint8_t LEAK_PIN = 33; /* to ground when wet; NO_PIN: none */

/* RC receiver: USV_RC_NONE; USV_RC_PPM, a sum signal on PPM_PIN, which must have an interrupt; or USV_RC_SBUS or USV_RC_CRSF, on RC_PORT.
 * The signal of SBUS is inverted: an inverter turns it. CRSF at 420000 baud needs a board of 32 bits; a Mega does 400000, which ExpressLRS
 * can be set to. Battery, place, attitude and mode go back by CRSF to the transmitter's screen. */
#define RC_PROTOCOL USV_RC_PPM
static const uint8_t PPM_PIN = 2;
/* #define RC_PORT Serial1 */
#define CRSF_BAUD 420000

/* Analog inputs; NO_PIN: not measured. */
static const uint8_t VOLTAGE_PIN = A0;
static const uint8_t CURRENT_PIN = A1;
static const uint32_t VOLTAGE_FULL_MV = 25000; /* at full scale of the converter */
static const int32_t CURRENT_FULL_MA = 90000;
static const int32_t CURRENT_ZERO_MA = 0; /* reading without current */

#endif
