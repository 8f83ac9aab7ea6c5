/* One thruster; see usv_drive.h. */
#include "usv_drive.h"

#include <string.h>

#define LONGEST_STEP_MS 1000U /* a board that was held up for longer catches up by so much */
#define PATIENCE 2U           /* times of travel after which a thruster with end switches has jammed */

static int32_t wrapped(int32_t angle)
{
    angle %= USV_TURN;
    return angle > USV_TURN / 2 ? angle - USV_TURN : angle <= -USV_TURN / 2 ? angle + USV_TURN : angle;
}

static int32_t magnitude(int32_t value)
{
    return value < 0 ? -value : value;
}

/* How far a rate goes in that time; what the division leaves over counts the next time. */
static int32_t reach(int32_t rate_per_s, uint32_t elapsed_ms, uint32_t *rest)
{
    const uint32_t total = (uint32_t)rate_per_s * elapsed_ms + *rest;
    *rest = total % 1000U;
    return (int32_t)(total / 1000U);
}

static int32_t towards(int32_t from, int32_t to, int32_t most)
{
    const int32_t way = to - from;
    return from + (way > most ? most : way < -most ? -most : way);
}

uint16_t usv_throttle_us(const usv_drive_config *config, int16_t throttle)
{
    const bool ahead = (throttle > 0) != config->reversed;
    const int32_t end = ahead ? config->ahead_us : config->astern_us;
    const int32_t span = end - config->trim_us;
    if (throttle == 0) {
        return config->trim_us;
    }
    const int32_t dead = span < 0 ? -(int32_t)config->dead_us : (int32_t)config->dead_us;
    const int32_t share = magnitude(throttle) > USV_FULL_THROTTLE ? USV_FULL_THROTTLE : magnitude(throttle);
    const int32_t live = (span - dead) * share; /* within ±2000 · 10000 */
    return (uint16_t)(config->trim_us + dead + (live + (live < 0 ? -USV_FULL_THROTTLE : USV_FULL_THROTTLE) / 2) / USV_FULL_THROTTLE);
}

void usv_drive_start(usv_drive *drive, const usv_drive_config *config)
{
    memset(drive, 0, sizeof *drive);
    drive->azimuth = config->azimuth_rest;
}

/* --- retraction --------------------------------------------------------------------------------------------------- */

static bool arrived(const usv_drive *drive, const usv_drive_config *config, const usv_drive_input *input, int8_t lower)
{
    if (config->end_switches) {
        return lower == USV_LOWER ? input->switch_down && !input->switch_up : input->switch_up && !input->switch_down;
    }
    return drive->placed && drive->at_ms == (lower == USV_LOWER ? config->travel_ms : 0);
}

static uint8_t deployment(const usv_drive *drive, const usv_drive_config *config, const usv_drive_input *input)
{
    if (config->travel_ms == 0) {
        return USV_UNSAID;
    }
    if (arrived(drive, config, input, USV_LOWER)) {
        return USV_DOWN;
    }
    if (arrived(drive, config, input, USV_RAISE)) {
        return USV_UP;
    }
    return config->end_switches || drive->placed || drive->going != USV_STAY ? USV_MOVING : USV_UNSAID;
}

void usv_drive_send(usv_drive *drive, const usv_drive_config *config, const usv_drive_input *input, int8_t lower)
{
    if (config->travel_ms == 0 || lower == USV_STAY || lower == drive->going) {
        return;
    }
    if (lower != drive->gave_up) {
        drive->gave_up = USV_STAY;
        if (!arrived(drive, config, input, lower)) {
            drive->going = lower;
            drive->spent_ms = 0;
            if (!drive->placed) { /* as far away as it can be */
                drive->at_ms = lower == USV_LOWER ? 0 : config->travel_ms;
            }
        } else {
            drive->going = USV_STAY;
        }
    }
}

static void travel(usv_drive *drive, const usv_drive_config *config, const usv_drive_input *input, uint32_t elapsed_ms)
{
    if (drive->going == USV_STAY) {
        return;
    }
    drive->spent_ms += elapsed_ms;
    if (drive->going == USV_LOWER) {
        const uint32_t left = config->travel_ms - drive->at_ms;
        drive->at_ms += elapsed_ms < left ? elapsed_ms : left;
    } else {
        drive->at_ms -= elapsed_ms < drive->at_ms ? elapsed_ms : drive->at_ms;
    }
    if (!config->end_switches && drive->at_ms == (drive->going == USV_LOWER ? config->travel_ms : 0)) {
        drive->placed = true;
    }
    if (arrived(drive, config, input, drive->going)) {
        drive->going = USV_STAY;
    } else if (config->end_switches && drive->spent_ms > PATIENCE * config->travel_ms) {
        drive->gave_up = drive->going;
        drive->going = USV_STAY;
    }
}

/* --- azimuth ------------------------------------------------------------------------------------------------------ */

/* Where a drive goes for a direction: the shorter way round, or the turn within the stops that is nearest, or the nearer stop. */
static int32_t standpoint(const usv_drive *drive, const usv_drive_config *config, int32_t direction)
{
    const int32_t nearest = drive->azimuth + wrapped(direction - drive->azimuth);
    if (config->azimuth == USV_ENDLESS) {
        return nearest;
    }
    bool found = false;
    int32_t best = 0;
    for (int8_t turn = -1; turn <= 1; turn++) {
        const int32_t there = nearest + turn * USV_TURN;
        const bool within = there >= config->azimuth_min && there <= config->azimuth_max;
        if (within && (!found || magnitude(there - drive->azimuth) < magnitude(best - drive->azimuth))) {
            found = true;
            best = there;
        }
    }
    if (found) {
        return best;
    }
    const int32_t to_min = magnitude(wrapped(direction - config->azimuth_min)), to_max = magnitude(wrapped(direction - config->azimuth_max));
    return to_min < to_max ? config->azimuth_min : config->azimuth_max;
}

static void turn(usv_drive *drive, const usv_drive_config *config, int16_t azimuth, uint32_t elapsed_ms)
{
    const int32_t most = reach(config->azimuth_rate, elapsed_ms, &drive->azimuth_rest);
    if (config->azimuth != USV_FIXED && azimuth != USV_NO_AZIMUTH) {
        drive->azimuth = towards(drive->azimuth, standpoint(drive, config, azimuth), most);
        if (config->azimuth == USV_ENDLESS) {
            drive->azimuth = wrapped(drive->azimuth);
        }
    }
}

/* --- all of it ---------------------------------------------------------------------------------------------------- */

void usv_drive_step(usv_drive *drive, const usv_drive_config *config, const usv_drive_input *input, int16_t throttle, int16_t azimuth,
                    uint32_t elapsed_ms)
{
    elapsed_ms = elapsed_ms < LONGEST_STEP_MS ? elapsed_ms : LONGEST_STEP_MS;
    travel(drive, config, input, elapsed_ms);
    turn(drive, config, azimuth, elapsed_ms);
    if (config->travel_ms != 0 && (drive->going == USV_RAISE || deployment(drive, config, input) != USV_DOWN)) {
        throttle = 0;
    }
    const int32_t most = reach(config->rate_per_s, elapsed_ms, &drive->throttle_rest);
    const bool across = (throttle > 0) != (drive->throttle > 0);
    if (across || magnitude(throttle) < magnitude(drive->throttle)) {
        drive->throttle = across ? 0 : throttle;
    }
    drive->throttle = config->rate_per_s == 0 ? throttle : (int16_t)towards(drive->throttle, throttle, most);
}

usv_drive_output usv_drive_out(const usv_drive *drive, const usv_drive_config *config)
{
    usv_drive_output out = {usv_throttle_us(config, drive->throttle), 0, drive->azimuth, drive->going};
    if (config->azimuth == USV_WITH_STOPS && config->azimuth_max > config->azimuth_min) {
        const int32_t span_us = (int32_t)config->azimuth_max_us - config->azimuth_min_us;
        const int32_t span = config->azimuth_max - config->azimuth_min;
        out.azimuth_us = (uint16_t)(config->azimuth_min_us + (drive->azimuth - config->azimuth_min) * span_us / span);
    }
    return out;
}

usv_thruster_state usv_drive_state(const usv_drive *drive, const usv_drive_config *config, const usv_drive_input *input)
{
    usv_thruster_state state;
    state.throttle = input->throttle_measured ? input->throttle : drive->throttle;
    state.azimuth = USV_NO_AZIMUTH;
    if (config->azimuth != USV_FIXED) {
        state.azimuth = input->azimuth_measured ? input->azimuth : (int16_t)wrapped(drive->azimuth);
    }
    state.works = input->works;
    state.deployment = deployment(drive, config, input);
    return state;
}
