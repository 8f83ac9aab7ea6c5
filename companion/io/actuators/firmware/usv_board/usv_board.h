/*
 * The board: frames and sensors in → outputs and frames out. No platform in it, nothing allocated.
 *
 *     usv_board_start(&board, &config, now_ms);
 *     for ever:
 *         for each byte that came in:      usv_board_hear(&board, byte, now_ms);
 *         read sensors, receiver, switches into board.in
 *         usv_board_step(&board, now_ms);
 *         write board.out to pins
 *         while ((length = usv_board_speak(&board, now_ms, frame)) > 0) send(frame, length);
 *
 * `now_ms` counts up and may wrap. Thrusters are neutral unless the last valid COMMAND was armed and is less than 0.5 s old.
 */
#ifndef USV_BOARD_H
#define USV_BOARD_H

#include "usv_drive.h"

#ifdef __cplusplus
extern "C" {
#endif

#define USV_WATCHDOG_MS 500U
#define USV_STATUS_MS 50U

/* What the transmitter's safe-mode switch does on the board itself; in any case the companion sees all channels. */
enum { USV_SAFE_NOTHING, USV_SAFE_CUT, USV_SAFE_STICKS };

typedef struct {
    const char *name; /* ASCII; the first 32 characters count */
    uint8_t thrusters, relays, servos;
    const usv_drive_config *thruster; /* that many */
    uint8_t safe_action;
    uint8_t safe_channel;                             /* from 1; high is on */
    uint8_t surge_channel, sway_channel, yaw_channel; /* from 1; 0: no such stick */
} usv_board_config;

typedef struct {
    bool leak_wet;
    uint16_t battery_mv; /* USV_NO_VOLTAGE where it is not measured; the next two likewise */
    int32_t current_ma;
    uint8_t remaining;
    bool rc_present;  /* there is a receiver */
    bool rc_fresh;    /* `rc_us` came in since the last step */
    bool takes_radio; /* `out.radio` is sent to the receiver */
    uint16_t rc_us[USV_RC_CHANNELS];
    usv_drive_input thruster[USV_MAX_THRUSTERS];
} usv_board_in;

typedef struct {
    usv_drive_output thruster[USV_MAX_THRUSTERS];
    bool red, yellow, green; /* lit at this moment */
    usv_outputs auxiliary;
    usv_radio radio; /* for the RC receiver; set `length` to 0 once it is sent */
} usv_board_out;

typedef struct {
    usv_board_in in;
    usv_board_out out;
    const usv_board_config *config;
    usv_receiver receiver;
    usv_message message; /* the last that came in, or the next that goes out */
    usv_command command; /* the last valid one */
    usv_drive drive[USV_MAX_THRUSTERS];
    uint32_t stepped_ms, commanded_ms, auxiliary_ms, status_ms, rc_ms;
    bool commanded;  /* and less than 0.5 s ago */
    bool late;       /* no command has come for 0.5 s */
    bool auxiliary, auxiliary_heard;
    bool rc_lost, safe_mode, must_centre;
    bool introduce, say_auxiliary;
} usv_board;

void usv_board_start(usv_board *board, const usv_board_config *config, uint32_t now_ms);
void usv_board_hear(usv_board *board, uint8_t byte, uint32_t now_ms);
void usv_board_step(usv_board *board, uint32_t now_ms);

/* The next frame that is due, of USV_MAX_FRAME bytes at most, or 0. Call until it gives 0. */
size_t usv_board_speak(usv_board *board, uint32_t now_ms, uint8_t *frame);

#ifdef __cplusplus
}
#endif

#endif
