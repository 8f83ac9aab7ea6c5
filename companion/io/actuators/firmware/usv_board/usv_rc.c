/* Serial RC receivers; see usv_rc.h. */
#include "usv_rc.h"

#include <string.h>

#define BITS 11U
#define MASK 0x7FFU

#define CRSF_LEAST 2U /* of the length field */
#define CRSF_MOST 62U
#define CRSF_CHANNELS 0x16
#define CRSF_LINK 0x14
#define CRSF_CHANNELS_LENGTH 22U
#define CRSF_LINK_LENGTH 10U
#define CRSF_QUALITY_AT 2U /* of the link towards the boat, per cent */
#define CRSF_PROVEN 3U
#define CRSF_LINK_MS 1000U /* a lost link is news for so long */

#define SBUS_LENGTH 25U
#define SBUS_HEADER 0x0F
#define SBUS_FRAME_LOST 0x04
#define SBUS_FAILSAFE 0x08
#define SBUS_UNUSED 0xF0
#define SBUS_GAP_MS 2U /* a frame takes 3 ms, and comes every 7 or 14 ms */
#define SBUS_PROVEN 10U
#define SBUS_JUMP 100 /* steps, 62 us; no stick goes there and back within two frames */

void usv_rc_start(usv_rc *rc, uint8_t protocol)
{
    memset(rc, 0, sizeof *rc);
    rc->protocol = protocol;
}

/* The first eight values of 11 bits, the lowest bit first. */
static void unpack(const uint8_t *data, uint16_t *value)
{
    uint32_t bits = 0;
    uint8_t held = 0;
    for (uint8_t i = 0; i < USV_RC_CHANNELS; i++) {
        while (held < BITS) {
            bits |= (uint32_t)*data++ << held;
            held = (uint8_t)(held + 8U);
        }
        value[i] = (uint16_t)(bits & MASK);
        bits >>= BITS;
        held = (uint8_t)(held - BITS);
    }
}

/* 992 is 1500 us; a step is 5/8 us. */
static uint16_t pulse(uint16_t value)
{
    return (uint16_t)((7044U + 5U * value) / 8U);
}

static void count_clean(usv_rc *rc)
{
    rc->clean = rc->clean < UINT8_MAX ? (uint8_t)(rc->clean + 1U) : rc->clean;
}

static void drop(usv_rc *rc, uint8_t count)
{
    rc->length = (uint8_t)(rc->length - count);
    memmove(rc->buffer, rc->buffer + count, rc->length);
}

/* --- CRSF --------------------------------------------------------------------------------------------------------- */

/* CRC-8, polynomial 0xD5. */
static uint8_t crsf_crc(const uint8_t *data, uint8_t length)
{
    uint8_t crc = 0;
    for (uint8_t i = 0; i < length; i++) {
        crc = (uint8_t)(crc ^ data[i]);
        for (uint8_t bit = 0; bit < 8; bit++) {
            crc = (crc & 0x80U) != 0 ? (uint8_t)((uint8_t)(crc << 1) ^ 0xD5U) : (uint8_t)(crc << 1);
        }
    }
    return crc;
}

static bool crsf_begins(const uint8_t *at)
{
    const bool address = at[0] == 0xC8 || at[0] == 0xEA || at[0] == 0xEC || at[0] == 0xEE || at[0] == 0x00;
    return address && at[1] >= CRSF_LEAST && at[1] <= CRSF_MOST;
}

/* A frame without a fault; true when its channels count. */
static bool crsf_take(usv_rc *rc, const uint8_t *body, uint8_t length, uint32_t now_ms, uint16_t *us)
{
    count_clean(rc);
    if (rc->clean < CRSF_PROVEN) {
        return false;
    }
    if (body[0] == CRSF_LINK && length == CRSF_LINK_LENGTH + 1U) {
        rc->unlinked = body[1 + CRSF_QUALITY_AT] == 0;
        rc->link_ms = now_ms;
        if (rc->unlinked) {
            memset(us, 0, USV_RC_CHANNELS * sizeof *us);
        }
        return rc->unlinked;
    }
    if (body[0] != CRSF_CHANNELS || length != CRSF_CHANNELS_LENGTH + 1U) {
        return false;
    }
    rc->unlinked = rc->unlinked && now_ms - rc->link_ms <= CRSF_LINK_MS;
    memset(us, 0, USV_RC_CHANNELS * sizeof *us);
    if (!rc->unlinked) {
        unpack(body + 1, us);
        for (uint8_t i = 0; i < USV_RC_CHANNELS; i++) {
            us[i] = pulse(us[i]);
        }
    }
    return true;
}

static bool crsf_hear(usv_rc *rc, uint32_t now_ms, uint16_t *us)
{
    bool counts = false;
    while (rc->length > CRSF_LEAST) {
        const uint8_t length = rc->buffer[1];
        uint8_t spent = 1;
        if (!crsf_begins(rc->buffer)) {
            rc->clean = 0;
        } else if (rc->length < length + 2U) {
            break;
        } else if (crsf_crc(rc->buffer + 2, (uint8_t)(length - 1U)) != rc->buffer[length + 1U]) {
            rc->errors++;
            rc->clean = 0;
        } else {
            counts = crsf_take(rc, rc->buffer + 2, (uint8_t)(length - 1U), now_ms, us) || counts;
            spent = (uint8_t)(length + 2U);
        }
        drop(rc, spent);
    }
    return counts;
}

/* --- SBUS --------------------------------------------------------------------------------------------------------- */

static bool sbus_whole(const uint8_t *frame)
{
    const uint8_t end = frame[SBUS_LENGTH - 1U], flags = frame[SBUS_LENGTH - 2U];
    const bool ends = end == 0x00 || end == 0x04 || end == 0x14 || end == 0x24 || end == 0x34;
    return frame[0] == SBUS_HEADER && ends && (flags & SBUS_UNUSED) == 0;
}

static uint16_t middle(uint16_t a, uint16_t b, uint16_t c)
{
    const uint16_t low = a < b ? a : b, high = a < b ? b : a;
    return c < low ? low : c > high ? high : c;
}

static bool sbus_jumps(const usv_rc *rc)
{
    for (uint8_t i = 0; i < USV_RC_CHANNELS; i++) {
        const int16_t a = (int16_t)rc->value[0][i], b = (int16_t)rc->value[1][i], c = (int16_t)rc->value[2][i];
        if (b < (a < c ? a : c) - SBUS_JUMP || b > (a < c ? c : a) + SBUS_JUMP) {
            return true;
        }
    }
    return false;
}

static bool sbus_most(const usv_rc *rc, uint8_t bit)
{
    return ((rc->flags[0] & bit) != 0) + ((rc->flags[1] & bit) != 0) + ((rc->flags[2] & bit) != 0) > USV_RC_ROW / 2;
}

/* A frame that stands where one is due; true when its channels count. */
static bool sbus_take(usv_rc *rc, uint16_t *us)
{
    memmove(rc->value[0], rc->value[1], 2 * sizeof rc->value[0]);
    rc->flags[0] = rc->flags[1];
    rc->flags[1] = rc->flags[2];
    unpack(rc->buffer + 1, rc->value[2]);
    rc->flags[2] = rc->buffer[SBUS_LENGTH - 2U];
    rc->row = rc->row < USV_RC_ROW ? (uint8_t)(rc->row + 1U) : rc->row;
    count_clean(rc);
    if (rc->row == USV_RC_ROW && sbus_jumps(rc)) {
        rc->errors++;
        rc->clean = 0;
    }
    if (rc->clean < SBUS_PROVEN) {
        return false;
    }
    const bool failsafe = sbus_most(rc, SBUS_FAILSAFE);
    for (uint8_t i = 0; i < USV_RC_CHANNELS; i++) {
        us[i] = failsafe ? 0 : pulse(middle(rc->value[0][i], rc->value[1][i], rc->value[2][i]));
    }
    return failsafe || !sbus_most(rc, SBUS_FRAME_LOST); /* lost frames repeat old channels: silence */
}

/* Frames are found by the gap between them, then by their length. */
static bool sbus_hear(usv_rc *rc, uint32_t gap_ms, uint16_t *us)
{
    if (!rc->synced && gap_ms >= SBUS_GAP_MS) {
        rc->buffer[0] = rc->buffer[rc->length - 1U];
        rc->length = 1;
    } else if (!rc->synced && rc->length == 1) {
        rc->length = 0; /* waits for a gap */
    }
    if (rc->length < SBUS_LENGTH) {
        return false;
    }
    const bool whole = sbus_whole(rc->buffer);
    rc->length = 0;
    if (!whole) {
        rc->errors = (uint16_t)(rc->errors + (rc->synced ? 1U : 0U));
        rc->clean = rc->row = 0;
    }
    rc->synced = whole;
    return whole && sbus_take(rc, us);
}

bool usv_rc_hear(usv_rc *rc, uint8_t byte, uint32_t now_ms, uint16_t us[USV_RC_CHANNELS])
{
    const uint32_t gap_ms = now_ms - rc->heard_ms;
    rc->heard_ms = now_ms;
    rc->buffer[rc->length++] = byte;
    if (rc->protocol == USV_RC_CRSF) {
        return crsf_hear(rc, now_ms, us);
    }
    if (rc->protocol == USV_RC_SBUS) {
        return sbus_hear(rc, gap_ms, us);
    }
    rc->length = 0;
    return false;
}
