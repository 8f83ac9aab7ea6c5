/*
 * An RC receiver on a serial port of the board, SBUS or CRSF: bytes in → pulses of the first eight channels out.
 *
 * The rules are those of `companion/io/sensors/sbus.py` and `crsf.py`, which name the sources. CRSF has a checksum: frames count from the
 * third in a row without a fault. SBUS has none: they count from the tenth, and a channel is the median of the last three.
 */
#ifndef USV_RC_H
#define USV_RC_H

#include "usv_frame.h"

#ifdef __cplusplus
extern "C" {
#endif

#define USV_RC_BYTES 64 /* of the longest frame */
#define USV_RC_ROW 3

enum { USV_RC_NONE, USV_RC_PPM, USV_RC_SBUS, USV_RC_CRSF };

typedef struct {
    uint8_t protocol;
    uint8_t buffer[USV_RC_BYTES];
    uint8_t length;
    uint8_t clean; /* frames in a row without a fault, up to 255 */
    bool synced;   /* SBUS: the last frame stood where one was due */
    uint8_t row;   /* SBUS: how many of the last three frames are known */
    uint16_t value[USV_RC_ROW][USV_RC_CHANNELS];
    uint8_t flags[USV_RC_ROW];
    bool unlinked; /* CRSF: the radio link is lost */
    uint32_t heard_ms, link_ms;
    uint16_t errors; /* spoilt frames */
} usv_rc;

void usv_rc_start(usv_rc *rc, uint8_t protocol);

/* One byte; true when it completes a frame that counts: `us` has its pulses then, all of them 0 where the receiver has lost its transmitter. */
bool usv_rc_hear(usv_rc *rc, uint8_t byte, uint32_t now_ms, uint16_t us[USV_RC_CHANNELS]);

#ifdef __cplusplus
}
#endif

#endif
