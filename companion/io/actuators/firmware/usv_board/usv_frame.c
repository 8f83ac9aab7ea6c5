/* The codec; see usv_frame.h. */
#include "usv_frame.h"

#include <string.h>

uint16_t usv_crc(const uint8_t *data, size_t length)
{
    uint16_t crc = 0xFFFF;
    for (size_t i = 0; i < length; i++) {
        crc = (uint16_t)(crc ^ ((uint16_t)data[i] << 8));
        for (uint8_t bit = 0; bit < 8; bit++) {
            crc = (crc & 0x8000) != 0 ? (uint16_t)((uint16_t)(crc << 1) ^ 0x1021) : (uint16_t)(crc << 1);
        }
    }
    return crc;
}

/* --- little endian ------------------------------------------------------------------------------------------------ */

static uint16_t get_u16(const uint8_t *at)
{
    return (uint16_t)(at[0] | (uint16_t)((uint16_t)at[1] << 8));
}

static int16_t get_i16(const uint8_t *at)
{
    const uint16_t raw = get_u16(at);
    return raw < 0x8000U ? (int16_t)raw : (int16_t)((int32_t)raw - 0x10000L);
}

static int32_t get_i32(const uint8_t *at)
{
    const uint32_t raw = (uint32_t)get_u16(at) | ((uint32_t)get_u16(at + 2) << 16);
    return raw <= 0x7FFFFFFFUL ? (int32_t)raw : -1 - (int32_t)(0xFFFFFFFFUL - raw);
}

static uint8_t *put_u8(uint8_t *at, uint8_t value)
{
    *at = value;
    return at + 1;
}

static uint8_t *put_u16(uint8_t *at, uint16_t value)
{
    at[0] = (uint8_t)(value & 0xFF);
    at[1] = (uint8_t)(value >> 8);
    return at + 2;
}

static uint8_t *put_i16(uint8_t *at, int16_t value)
{
    return put_u16(at, (uint16_t)value);
}

static uint8_t *put_i32(uint8_t *at, int32_t value)
{
    return put_u16(put_u16(at, (uint16_t)((uint32_t)value & 0xFFFF)), (uint16_t)((uint32_t)value >> 16));
}

/* --- limits ------------------------------------------------------------------------------------------------------- */

static bool sensible(int16_t throttle, int16_t azimuth)
{
    const bool throttle_ok = throttle >= -USV_FULL_THROTTLE && throttle <= USV_FULL_THROTTLE;
    return throttle_ok && (azimuth == USV_NO_AZIMUTH || (azimuth >= -USV_MAX_AZIMUTH && azimuth <= USV_MAX_AZIMUTH));
}

static int16_t limited(int16_t value, int16_t most)
{
    return value > most ? most : value < -most ? (int16_t)-most : value;
}

static int16_t limited_azimuth(int16_t azimuth)
{
    if (azimuth == USV_NO_AZIMUTH) {
        return azimuth;
    }
    return azimuth <= -USV_MAX_AZIMUTH ? USV_MAX_AZIMUTH : limited(azimuth, USV_MAX_AZIMUTH); /* one value for astern */
}

static uint16_t limited_pulse(uint16_t pulse_us)
{
    if (pulse_us == 0) {
        return 0;
    }
    return pulse_us < USV_SHORTEST_US ? USV_SHORTEST_US : pulse_us > USV_LONGEST_US ? USV_LONGEST_US : pulse_us;
}

static bool bit(uint8_t flags, uint8_t number)
{
    return ((flags >> number) & 1) != 0;
}

/* --- out ---------------------------------------------------------------------------------------------------------- */

static uint8_t *put_command(uint8_t *at, const usv_command *command)
{
    const uint8_t lower = command->lower == USV_LOWER ? 2 : command->lower == USV_RAISE ? 4 : 0;
    at = put_u8(at, command->sequence);
    at = put_u8(at, (uint8_t)((command->armed ? 1 : 0) | lower));
    at = put_u8(at, (uint8_t)((command->red & 3) | ((command->yellow & 3) << 2) | ((command->green & 3) << 4)));
    at = put_u8(at, command->thrusters);
    for (uint8_t i = 0; i < command->thrusters; i++) {
        at = put_i16(at, limited(command->demand[i].throttle, USV_FULL_THROTTLE));
        at = put_i16(at, limited_azimuth(command->demand[i].azimuth));
    }
    return at;
}

static uint8_t *put_status(uint8_t *at, const usv_status *status)
{
    const bool flags[6] = {status->neutral_by_watchdog, status->leak_wet,  status->rc_present,
                           status->rc_lost,             status->safe_mode, status->takes_radio};
    uint8_t packed = 0;
    for (uint8_t i = 0; i < 6; i++) {
        packed = (uint8_t)(packed | ((flags[i] ? 1U : 0U) << i));
    }
    at = put_u8(at, status->sequence);
    at = put_u8(at, packed);
    at = put_u16(at, status->battery_mv);
    at = put_i32(at, status->current_ma);
    at = put_u8(at, status->remaining);
    for (uint8_t i = 0; i < USV_RC_CHANNELS; i++) {
        at = put_u16(at, status->rc_us[i]);
    }
    at = put_u8(at, status->thrusters);
    for (uint8_t i = 0; i < status->thrusters; i++) {
        const usv_thruster_state *state = &status->state[i];
        at = put_i16(at, limited(state->throttle, USV_FULL_THROTTLE));
        at = put_i16(at, limited_azimuth(state->azimuth));
        at = put_u8(at, (uint8_t)((state->works ? 1 : 0) | ((state->deployment & 3) << 1)));
    }
    return at;
}

static uint8_t *put_ident(uint8_t *at, const usv_ident *ident)
{
    for (uint8_t i = 0; i < 3; i++) {
        at = put_u8(at, ident->firmware[i]);
    }
    at = put_u8(at, ident->thrusters);
    at = put_u8(at, ident->length);
    for (uint8_t i = 0; i < ident->length; i++) {
        at = put_u8(at, (uint8_t)((uint8_t)ident->name[i] < 0x80 ? ident->name[i] : '?'));
    }
    return at;
}

static uint8_t *put_outputs(uint8_t *at, const usv_outputs *outputs)
{
    const uint16_t there = (uint16_t)((1UL << outputs->relay_count) - 1);
    at = put_u8(at, outputs->sequence);
    at = put_u16(at, (uint16_t)(outputs->relays & there));
    at = put_u8(at, outputs->relay_count);
    at = put_u8(at, outputs->servo_count);
    for (uint8_t i = 0; i < outputs->servo_count; i++) {
        at = put_u16(at, limited_pulse(outputs->servo_us[i]));
    }
    return at;
}

/* COBS in place: the message stands from frame[2] on; frame[0] is the first delimiter, frame[1] the first code. */
static size_t close_frame(uint8_t *frame, size_t length)
{
    size_t code_at = 1;
    frame[0] = 0;
    for (size_t at = 2; at < length + 2; at++) {
        if (frame[at] == 0) {
            frame[code_at] = (uint8_t)(at - code_at);
            code_at = at;
        }
    }
    frame[code_at] = (uint8_t)(length + 2 - code_at);
    frame[length + 2] = 0;
    return length + 3;
}

size_t usv_encode(const usv_message *message, uint8_t *frame)
{
    uint8_t *const start = frame + 2;
    uint8_t *at = put_u8(put_u8(start, USV_VERSION), message->type);
    switch (message->type) {
    case USV_COMMAND:
        if (message->body.command.thrusters > USV_MAX_THRUSTERS) {
            return 0;
        }
        at = put_command(at, &message->body.command);
        break;
    case USV_STATUS:
        if (message->body.status.thrusters > USV_MAX_THRUSTERS) {
            return 0;
        }
        at = put_status(at, &message->body.status);
        break;
    case USV_IDENT_REQUEST:
        break;
    case USV_IDENT:
        if (message->body.ident.length > USV_MAX_NAME) {
            return 0;
        }
        at = put_ident(at, &message->body.ident);
        break;
    case USV_AUXILIARY:
    case USV_AUXILIARY_STATUS:
        if (message->body.outputs.relay_count > USV_MAX_OUTPUTS || message->body.outputs.servo_count > USV_MAX_OUTPUTS) {
            return 0;
        }
        at = put_outputs(at, &message->body.outputs);
        break;
    case USV_RADIO:
        if (message->body.radio.length == 0 || message->body.radio.length > USV_MAX_RADIO) {
            return 0;
        }
        memcpy(at, message->body.radio.data, message->body.radio.length);
        at += message->body.radio.length;
        break;
    default:
        return 0;
    }
    at = put_u16(at, usv_crc(start, (size_t)(at - start)));
    return close_frame(frame, (size_t)(at - start));
}

/* --- in ----------------------------------------------------------------------------------------------------------- */

static bool get_command(const uint8_t *body, size_t length, usv_command *command)
{
    if (length < 6) {
        return false;
    }
    const uint8_t flags = body[3], lights = body[4], n = body[5];
    if (n > USV_MAX_THRUSTERS || length != 6U + 4U * n || flags > 5 || lights > 0x3F) {
        return false;
    }
    command->sequence = body[2];
    command->armed = bit(flags, 0);
    command->lower = bit(flags, 1) ? USV_LOWER : bit(flags, 2) ? USV_RAISE : USV_STAY;
    command->red = lights & 3;
    command->yellow = (lights >> 2) & 3;
    command->green = (lights >> 4) & 3;
    if (command->red > USV_LIGHT_BLINK || command->yellow > USV_LIGHT_BLINK || command->green > USV_LIGHT_BLINK) {
        return false;
    }
    command->thrusters = n;
    for (uint8_t i = 0; i < n; i++) {
        command->demand[i].throttle = get_i16(body + 6 + 4 * i);
        command->demand[i].azimuth = get_i16(body + 8 + 4 * i);
        if (!sensible(command->demand[i].throttle, command->demand[i].azimuth)) {
            return false;
        }
    }
    return true;
}

static bool get_states(const uint8_t *body, usv_status *status)
{
    for (uint8_t i = 0; i < status->thrusters; i++) {
        const uint8_t *at = body + 28 + 5 * i;
        usv_thruster_state *state = &status->state[i];
        state->throttle = get_i16(at);
        state->azimuth = get_i16(at + 2);
        if (at[4] > 7 || !sensible(state->throttle, state->azimuth)) {
            return false;
        }
        state->works = bit(at[4], 0);
        state->deployment = at[4] >> 1;
    }
    return true;
}

static bool get_status(const uint8_t *body, size_t length, usv_status *status)
{
    if (length < 28 || body[27] > USV_MAX_THRUSTERS || length != 28U + 5U * body[27] || body[3] > 0x3F) {
        return false;
    }
    status->sequence = body[2];
    status->neutral_by_watchdog = bit(body[3], 0);
    status->leak_wet = bit(body[3], 1);
    status->rc_present = bit(body[3], 2);
    status->rc_lost = bit(body[3], 3);
    status->safe_mode = bit(body[3], 4);
    status->takes_radio = bit(body[3], 5);
    status->battery_mv = get_u16(body + 4);
    status->current_ma = get_i32(body + 6);
    status->remaining = body[10];
    for (uint8_t i = 0; i < USV_RC_CHANNELS; i++) {
        status->rc_us[i] = get_u16(body + 11 + 2 * i);
    }
    status->thrusters = body[27];
    return get_states(body, status);
}

static bool get_ident(const uint8_t *body, size_t length, usv_ident *ident)
{
    if (length < 7 || body[6] > USV_MAX_NAME || length != 7U + body[6]) {
        return false;
    }
    memcpy(ident->firmware, body + 2, 3);
    ident->thrusters = body[5];
    ident->length = body[6];
    for (uint8_t i = 0; i < ident->length; i++) {
        if (body[7 + i] >= 0x80) {
            return false;
        }
        ident->name[i] = (char)body[7 + i];
    }
    return true;
}

static bool get_outputs(const uint8_t *body, size_t length, usv_outputs *outputs)
{
    if (length < 7 || body[5] > USV_MAX_OUTPUTS || body[6] > USV_MAX_OUTPUTS || length != 7U + 2U * body[6]) {
        return false;
    }
    outputs->sequence = body[2];
    outputs->relays = get_u16(body + 3);
    outputs->relay_count = body[5];
    outputs->servo_count = body[6];
    if (((uint32_t)outputs->relays >> outputs->relay_count) != 0) {
        return false;
    }
    for (uint8_t i = 0; i < outputs->servo_count; i++) {
        const uint16_t pulse_us = get_u16(body + 7 + 2 * i);
        if (limited_pulse(pulse_us) != pulse_us) {
            return false;
        }
        outputs->servo_us[i] = pulse_us;
    }
    return true;
}

static bool get_radio(const uint8_t *body, size_t length, usv_radio *radio)
{
    if (length < 3 || length > 2U + USV_MAX_RADIO) {
        return false;
    }
    radio->length = (uint8_t)(length - 2U);
    memcpy(radio->data, body + 2, radio->length);
    return true;
}

/* COBS undone in place; the length of the message, or 0 where it cannot be. */
static size_t open_frame(uint8_t *encoded, size_t length)
{
    size_t at = 0, out = 0;
    while (at < length) {
        const size_t end = at + encoded[at];
        if (encoded[at] == 0 || end > length) {
            return 0;
        }
        if (at > 0) {
            encoded[out++] = 0;
        }
        for (at++; at < end; at++) {
            encoded[out++] = encoded[at];
        }
    }
    return out;
}

bool usv_decode(uint8_t *encoded, size_t length, usv_message *message)
{
    const size_t whole = length > USV_MAX_ENCODED ? 0 : open_frame(encoded, length);
    if (whole < 4 || encoded[0] != USV_VERSION) {
        return false;
    }
    const size_t body = whole - 2;
    if (usv_crc(encoded, body) != get_u16(encoded + body)) {
        return false;
    }
    message->type = encoded[1];
    switch (message->type) {
    case USV_COMMAND:
        return get_command(encoded, body, &message->body.command);
    case USV_STATUS:
        return get_status(encoded, body, &message->body.status);
    case USV_IDENT_REQUEST:
        return body == 2;
    case USV_IDENT:
        return get_ident(encoded, body, &message->body.ident);
    case USV_AUXILIARY:
    case USV_AUXILIARY_STATUS:
        return get_outputs(encoded, body, &message->body.outputs);
    case USV_RADIO:
        return get_radio(encoded, body, &message->body.radio);
    default:
        return false;
    }
}

void usv_receiver_start(usv_receiver *receiver)
{
    memset(receiver, 0, sizeof *receiver);
}

bool usv_receive(usv_receiver *receiver, uint8_t byte, usv_message *message)
{
    if (byte != 0) {
        if (receiver->length < USV_MAX_ENCODED && !receiver->overrun) {
            receiver->buffer[receiver->length++] = byte;
        } else {
            receiver->overrun = true;
        }
        return false;
    }
    const bool something = receiver->length > 0 || receiver->overrun;
    const bool good = something && !receiver->overrun && usv_decode(receiver->buffer, receiver->length, message);
    if (good) {
        receiver->frames++;
    } else if (something) {
        receiver->errors++;
    }
    receiver->length = 0;
    receiver->overrun = false;
    return good;
}
