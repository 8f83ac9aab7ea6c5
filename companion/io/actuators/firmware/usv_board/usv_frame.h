/*
 * The frame between the companion and a microcontroller board: the codec in C99, for host and board.
 *
 * `companion/core/microcontroller_frame.py` and `microcontroller_auxiliary.py` describe the format byte by byte; this is written from that
 * text. Numbers are kept as on the wire: throttle in 1e-4, azimuth in 1e-4 rad, mV, mA, microseconds.
 * Nothing is allocated and every loop is bounded by the length of a frame.
 */
#ifndef USV_FRAME_H
#define USV_FRAME_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define USV_VERSION 1
#define USV_MAX_THRUSTERS 16
#define USV_MAX_OUTPUTS 16
#define USV_RC_CHANNELS 8
#define USV_MAX_NAME 32
#define USV_MAX_RADIO 64

#define USV_MAX_MESSAGE 253 /* shorter than the 254 from which COBS would need its long blocks */
#define USV_MAX_ENCODED (USV_MAX_MESSAGE + 1)
#define USV_MAX_FRAME (USV_MAX_ENCODED + 2)

#define USV_FULL_THROTTLE 10000
#define USV_MAX_AZIMUTH 31416
#define USV_NO_AZIMUTH INT16_MIN
#define USV_NO_VOLTAGE UINT16_MAX
#define USV_NO_CURRENT INT32_MIN
#define USV_NO_REMAINING UINT8_MAX
#define USV_SHORTEST_US 500
#define USV_LONGEST_US 2500

enum { USV_COMMAND = 1, USV_STATUS, USV_IDENT_REQUEST, USV_IDENT, USV_AUXILIARY, USV_AUXILIARY_STATUS, USV_RADIO };
enum { USV_LIGHT_OFF, USV_LIGHT_STEADY, USV_LIGHT_BLINK };
enum { USV_LOWER = 1, USV_RAISE = -1, USV_STAY = 0 };
enum { USV_UNSAID, USV_UP, USV_MOVING, USV_DOWN };

typedef struct {
    int16_t throttle;
    int16_t azimuth;
} usv_demand;

typedef struct {
    uint8_t sequence;
    bool armed;
    int8_t lower; /* USV_LOWER, USV_RAISE or USV_STAY */
    uint8_t red, yellow, green;
    uint8_t thrusters;
    usv_demand demand[USV_MAX_THRUSTERS];
} usv_command;

typedef struct {
    int16_t throttle;
    int16_t azimuth;
    bool works;
    uint8_t deployment; /* USV_UNSAID … USV_DOWN */
} usv_thruster_state;

typedef struct {
    uint8_t sequence;
    bool neutral_by_watchdog, leak_wet, rc_present, rc_lost, safe_mode, takes_radio;
    uint16_t battery_mv;
    int32_t current_ma;
    uint8_t remaining;
    uint16_t rc_us[USV_RC_CHANNELS];
    uint8_t thrusters;
    usv_thruster_state state[USV_MAX_THRUSTERS];
} usv_status;

typedef struct {
    uint8_t firmware[3];
    uint8_t thrusters;
    uint8_t length;
    char name[USV_MAX_NAME]; /* ASCII, not terminated */
} usv_ident;

typedef struct {
    uint8_t sequence;
    uint16_t relays; /* bit i: relay i is on */
    uint8_t relay_count;
    uint8_t servo_count;
    uint16_t servo_us[USV_MAX_OUTPUTS]; /* 0: no pulses */
} usv_outputs;

typedef struct {
    uint8_t length;
    uint8_t data[USV_MAX_RADIO]; /* for the RC receiver, as they are */
} usv_radio;

typedef struct {
    uint8_t type;
    union {
        usv_command command;
        usv_status status;
        usv_ident ident;
        usv_outputs outputs; /* of USV_AUXILIARY and USV_AUXILIARY_STATUS */
        usv_radio radio;
    } body;
} usv_message;

/* Bytes as they come in → messages. Remembers the unfinished frame, and counts. */
typedef struct {
    uint8_t buffer[USV_MAX_ENCODED];
    uint16_t length;
    bool overrun;
    uint32_t frames, errors;
} usv_receiver;

/* CRC-16/CCITT-FALSE. */
uint16_t usv_crc(const uint8_t *data, size_t length);

/* One frame, both delimiters included; `frame` holds USV_MAX_FRAME bytes. 0 for a message that no frame can hold. */
size_t usv_encode(const usv_message *message, uint8_t *frame);

/* The message in what stood between two delimiters, which is overwritten. False if it is damaged, unknown or impossible. */
bool usv_decode(uint8_t *encoded, size_t length, usv_message *message);

void usv_receiver_start(usv_receiver *receiver);

/* One byte; true when it completes a message. Garbage costs at most the frame that it hits. */
bool usv_receive(usv_receiver *receiver, uint8_t byte, usv_message *message);

#ifdef __cplusplus
}
#endif

#endif
