/*
 * One thruster on the board: throttle → pulse by its calibration, azimuth drive, retraction.
 *
 * Units are those of the frame: throttle in 1e-4, angles in 1e-4 rad clockwise from the bow, microseconds, milliseconds.
 */
#ifndef USV_DRIVE_H
#define USV_DRIVE_H

#include "usv_frame.h"

#ifdef __cplusplus
extern "C" {
#endif

#define USV_TURN INT32_C(62832) /* once round, in 1e-4 rad */

enum { USV_FIXED, USV_WITH_STOPS, USV_ENDLESS };

typedef struct {
    /* The pulse at standstill, full ahead and full astern; a drive that stands still up to `dead_us` either side of `trim_us` skips that. */
    uint16_t trim_us, ahead_us, astern_us, dead_us;
    bool reversed;
    uint16_t rate_per_s; /* most change of throttle away from standstill; 0: at once. Towards standstill it is always at once */

    uint8_t azimuth; /* USV_FIXED, USV_WITH_STOPS or USV_ENDLESS */
    int32_t azimuth_rest;
    int32_t azimuth_min, azimuth_max; /* stops, which may lie more than a turn apart */
    uint16_t azimuth_min_us, azimuth_max_us; /* pulses of a servo at its stops; either may be the longer */
    int32_t azimuth_rate; /* per second */

    uint32_t travel_ms; /* between up and down; 0: does not retract */
    bool end_switches;

    int8_t mix_surge, mix_sway, mix_yaw; /* per cent of each stick on the throttle, when the safe-mode switch gives the sticks the thrusters */
    int16_t mix_azimuth; /* azimuth from rest at full yaw stick, then */
} usv_drive_config;

/* Inputs of a thruster, read by the platform. */
typedef struct {
    bool works;
    bool throttle_measured, azimuth_measured;
    int16_t throttle, azimuth;
    bool switch_up, switch_down;
} usv_drive_input;

/* Outputs of a thruster, written by the platform. */
typedef struct {
    uint16_t pulse_us;
    uint16_t azimuth_us; /* 0 where no servo turns it */
    int32_t azimuth;     /* for a stepper: where to stand; (−π, π] of an endless one */
    int8_t travel;       /* USV_LOWER: run the motor downwards; USV_RAISE; USV_STAY: stop it */
} usv_drive_output;

typedef struct {
    int16_t throttle;
    int32_t azimuth;
    int8_t going;     /* the travel under way */
    int8_t gave_up;   /* a direction in which it did not arrive */
    bool placed;      /* `at_ms` is known */
    uint32_t at_ms;   /* 0 up … travel_ms down */
    uint32_t spent_ms;
    uint32_t throttle_rest, azimuth_rest; /* of the divisions of the rates */
} usv_drive;

void usv_drive_start(usv_drive *drive, const usv_drive_config *config);

/* Lower or raise a retractable thruster; USV_STAY ends a travel and begins none. */
void usv_drive_send(usv_drive *drive, const usv_drive_config *config, const usv_drive_input *input, int8_t lower);

/* `elapsed_ms` later. `throttle` 0: standstill, at once; `azimuth` USV_NO_AZIMUTH: leave it. */
void usv_drive_step(usv_drive *drive, const usv_drive_config *config, const usv_drive_input *input, int16_t throttle, int16_t azimuth,
                    uint32_t elapsed_ms);

usv_drive_output usv_drive_out(const usv_drive *drive, const usv_drive_config *config);

usv_thruster_state usv_drive_state(const usv_drive *drive, const usv_drive_config *config, const usv_drive_input *input);

/* The pulse for a throttle. */
uint16_t usv_throttle_us(const usv_drive_config *config, int16_t throttle);

#ifdef __cplusplus
}
#endif

#endif
