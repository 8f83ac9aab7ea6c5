/* The board; see usv_board.h. */
#include "usv_board.h"

#include <string.h>

#define FIRMWARE_MAJOR 1
#define FIRMWARE_MINOR 1
#define FIRMWARE_PATCH 0

#define BLINK_MS 500U
#define RC_LOST_MS 500U
#define RC_SHORTEST_US 800U /* many receivers report a lost transmitter by a pulse out of range */
#define RC_LONGEST_US 2200U
#define RC_CENTRE_US 1500
#define RC_IDLE_US 40 /* a stick no further from its centre is centred */
#define RC_HALF_RANGE_US 500
#define SAFE_ON_US 1750U
#define SAFE_OFF_US 1650U

void usv_board_start(usv_board *board, const usv_board_config *config, uint32_t now_ms)
{
    memset(board, 0, sizeof *board);
    board->config = config;
    usv_receiver_start(&board->receiver);
    for (uint8_t i = 0; i < config->thrusters; i++) {
        usv_drive_start(&board->drive[i], &config->thruster[i]);
        board->in.thruster[i].works = true;
        board->out.thruster[i] = usv_drive_out(&board->drive[i], &config->thruster[i]);
    }
    board->in.battery_mv = USV_NO_VOLTAGE;
    board->in.current_ma = USV_NO_CURRENT;
    board->in.remaining = USV_NO_REMAINING;
    board->out.auxiliary.relay_count = config->relays;
    board->out.auxiliary.servo_count = config->servos;
    board->stepped_ms = board->commanded_ms = board->status_ms = board->rc_ms = now_ms;
    board->rc_lost = true;
    board->introduce = true;
}

/* --- in ----------------------------------------------------------------------------------------------------------- */

static void obey(usv_board *board, uint32_t now_ms)
{
    if (board->message.body.command.thrusters != board->config->thrusters) {
        return; /* meant for another board */
    }
    board->command = board->message.body.command;
    board->commanded = true;
    board->late = false;
    board->commanded_ms = now_ms;
    for (uint8_t i = 0; i < board->config->thrusters; i++) {
        usv_drive_send(&board->drive[i], &board->config->thruster[i], &board->in.thruster[i], board->command.lower);
    }
}

void usv_board_hear(usv_board *board, uint8_t byte, uint32_t now_ms)
{
    if (!usv_receive(&board->receiver, byte, &board->message)) {
        return;
    }
    const usv_outputs *outputs = &board->message.body.outputs;
    switch (board->message.type) {
    case USV_COMMAND:
        obey(board, now_ms);
        break;
    case USV_IDENT_REQUEST:
        board->introduce = true;
        break;
    case USV_AUXILIARY:
        if (outputs->relay_count == board->config->relays && outputs->servo_count == board->config->servos) {
            board->out.auxiliary = *outputs;
            board->auxiliary = board->auxiliary_heard = true;
            board->auxiliary_ms = now_ms;
        }
        break;
    case USV_RADIO:
        board->out.radio = board->message.body.radio;
        break;
    default:
        break; /* messages from boards to hosts */
    }
}

/* --- the transmitter ---------------------------------------------------------------------------------------------- */

static uint16_t channel_us(const usv_board *board, uint8_t channel)
{
    return channel >= 1 && channel <= USV_RC_CHANNELS ? board->in.rc_us[channel - 1] : 0;
}

/* −10000 … 10000; 0 for a stick that is centred or not there. */
static int32_t stick(const usv_board *board, uint8_t channel)
{
    const uint16_t pulse_us = channel_us(board, channel);
    const int32_t off = pulse_us == 0 ? 0 : (int32_t)pulse_us - RC_CENTRE_US;
    if (off > -RC_IDLE_US && off < RC_IDLE_US) {
        return 0;
    }
    const int32_t value = off * (USV_FULL_THROTTLE / RC_HALF_RANGE_US);
    return value > USV_FULL_THROTTLE ? USV_FULL_THROTTLE : value < -USV_FULL_THROTTLE ? -USV_FULL_THROTTLE : value;
}

static void mind_transmitter(usv_board *board, uint32_t now_ms)
{
    if (board->in.rc_present && board->in.rc_fresh) {
        bool sound = false;
        for (uint8_t i = 0; i < USV_RC_CHANNELS; i++) {
            const uint16_t pulse_us = board->in.rc_us[i];
            if (pulse_us != 0 && (pulse_us < RC_SHORTEST_US || pulse_us > RC_LONGEST_US)) {
                sound = false;
                break;
            }
            sound = sound || pulse_us != 0;
        }
        board->rc_lost = !sound;
        board->rc_ms = now_ms;
    }
    board->in.rc_fresh = false;
    if (!board->in.rc_present || now_ms - board->rc_ms >= RC_LOST_MS) {
        board->rc_lost = true;
        board->rc_ms = now_ms - RC_LOST_MS; /* and stays so, however long the silence */
    }
    if (board->rc_lost || board->config->safe_action == USV_SAFE_NOTHING) {
        return; /* the switch stays where it was last seen */
    }
    const bool on = channel_us(board, board->config->safe_channel) > (board->safe_mode ? SAFE_OFF_US : SAFE_ON_US);
    board->must_centre = on && (board->must_centre || !board->safe_mode);
    board->safe_mode = on;
    if (stick(board, board->config->surge_channel) == 0 && stick(board, board->config->sway_channel) == 0 &&
        stick(board, board->config->yaw_channel) == 0) {
        board->must_centre = false;
    }
}

/* The safe mode by sticks: no companion in it. */
static usv_demand by_stick(const usv_board *board, const usv_drive_config *thruster)
{
    usv_demand demand = {0, USV_NO_AZIMUTH};
    if (board->rc_lost || board->must_centre || board->config->safe_action != USV_SAFE_STICKS) {
        return demand;
    }
    const int32_t yaw = stick(board, board->config->yaw_channel);
    const int32_t mixed = (stick(board, board->config->surge_channel) * thruster->mix_surge +
                           stick(board, board->config->sway_channel) * thruster->mix_sway + yaw * thruster->mix_yaw) / 100;
    demand.throttle = (int16_t)(mixed > USV_FULL_THROTTLE ? USV_FULL_THROTTLE : mixed < -USV_FULL_THROTTLE ? -USV_FULL_THROTTLE : mixed);
    int32_t azimuth = (thruster->azimuth_rest + yaw * thruster->mix_azimuth / USV_FULL_THROTTLE) % USV_TURN;
    azimuth += azimuth > USV_MAX_AZIMUTH ? -USV_TURN : azimuth < -USV_MAX_AZIMUTH ? USV_TURN : 0;
    demand.azimuth = (int16_t)azimuth;
    return demand;
}

/* --- step --------------------------------------------------------------------------------------------------------- */

static bool lit(uint8_t light, uint32_t now_ms)
{
    return light == USV_LIGHT_STEADY || (light == USV_LIGHT_BLINK && (now_ms / BLINK_MS) % 2 == 0);
}

static void mind_silence(usv_board *board, uint32_t now_ms)
{
    if (!board->late && now_ms - board->commanded_ms >= USV_WATCHDOG_MS) {
        board->commanded = false; /* for good: a clock that wraps must not make an old command young */
        board->late = true;
    }
    if (board->auxiliary && now_ms - board->auxiliary_ms >= USV_WATCHDOG_MS) {
        board->auxiliary = false;
        board->out.auxiliary.relays = 0;
        memset(board->out.auxiliary.servo_us, 0, sizeof board->out.auxiliary.servo_us);
    }
}

void usv_board_step(usv_board *board, uint32_t now_ms)
{
    const usv_board_config *config = board->config;
    const uint32_t elapsed_ms = now_ms - board->stepped_ms;
    board->stepped_ms = now_ms;
    mind_silence(board, now_ms);
    mind_transmitter(board, now_ms);
    for (uint8_t i = 0; i < config->thrusters; i++) {
        usv_demand demand = {0, USV_NO_AZIMUTH};
        if (board->safe_mode) {
            demand = by_stick(board, &config->thruster[i]);
        } else if (board->commanded && board->command.armed) {
            demand = board->command.demand[i];
        }
        usv_drive_step(&board->drive[i], &config->thruster[i], &board->in.thruster[i], demand.throttle, demand.azimuth, elapsed_ms);
        board->out.thruster[i] = usv_drive_out(&board->drive[i], &config->thruster[i]);
    }
    board->out.red = lit(board->command.red, now_ms);
    board->out.yellow = lit(board->command.yellow, now_ms);
    board->out.green = board->late || lit(board->command.green, now_ms);
}

/* --- out ---------------------------------------------------------------------------------------------------------- */

static void introduce(usv_ident *ident, const usv_board_config *config)
{
    memset(ident, 0, sizeof *ident);
    ident->firmware[0] = FIRMWARE_MAJOR;
    ident->firmware[1] = FIRMWARE_MINOR;
    ident->firmware[2] = FIRMWARE_PATCH;
    ident->thrusters = config->thrusters;
    while (ident->length < USV_MAX_NAME && config->name[ident->length] != '\0') {
        ident->name[ident->length] = config->name[ident->length];
        ident->length++;
    }
}

static void describe(usv_status *status, const usv_board *board)
{
    const bool heard = board->in.rc_present && !board->rc_lost;
    status->sequence = board->command.sequence;
    status->neutral_by_watchdog = !board->commanded;
    status->leak_wet = board->in.leak_wet;
    status->rc_present = board->in.rc_present;
    status->rc_lost = board->in.rc_present && board->rc_lost;
    status->safe_mode = board->safe_mode;
    status->takes_radio = board->in.takes_radio;
    status->battery_mv = board->in.battery_mv;
    status->current_ma = board->in.current_ma;
    status->remaining = board->in.remaining;
    for (uint8_t i = 0; i < USV_RC_CHANNELS; i++) {
        status->rc_us[i] = heard ? board->in.rc_us[i] : 0;
    }
    status->thrusters = board->config->thrusters;
    for (uint8_t i = 0; i < status->thrusters; i++) {
        status->state[i] = usv_drive_state(&board->drive[i], &board->config->thruster[i], &board->in.thruster[i]);
    }
}

size_t usv_board_speak(usv_board *board, uint32_t now_ms, uint8_t *frame)
{
    if (board->introduce) {
        board->introduce = false;
        board->message.type = USV_IDENT;
        introduce(&board->message.body.ident, board->config);
    } else if (now_ms - board->status_ms >= USV_STATUS_MS) {
        /* on a grid, so that the rate holds whatever a turn of the loop takes */
        board->status_ms = now_ms - board->status_ms < 2 * USV_STATUS_MS ? board->status_ms + USV_STATUS_MS : now_ms;
        board->say_auxiliary = board->auxiliary_heard;
        board->message.type = USV_STATUS;
        describe(&board->message.body.status, board);
    } else if (board->say_auxiliary) {
        board->say_auxiliary = false;
        board->message.type = USV_AUXILIARY_STATUS;
        board->message.body.outputs = board->out.auxiliary;
    } else {
        return 0;
    }
    return usv_encode(&board->message, frame);
}
