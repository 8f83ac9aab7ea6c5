/*
 * The reference firmware on an Arduino: pins in, pins out, around the core in usv_board.c. board_config.h has the wiring.
 *
 * The loop never waits. A board that hangs is restarted by its own hardware watchdog, and starts neutral.
 */
#include <Servo.h>
#ifdef __AVR__
#include <avr/wdt.h>
#endif

#include "board_config.h"

#define BYTES_PER_TURN 128 /* a flooding host must not hold the loop */
#define PPM_GAP_US 3000U

static usv_board board;
#ifdef RC_PORT
static usv_rc receiver;
#else
static_assert(RC_PROTOCOL != USV_RC_SBUS && RC_PROTOCOL != USV_RC_CRSF, "SBUS and CRSF need an RC_PORT in board_config.h");
#endif
static Servo throttle[THRUSTER_COUNT], azimuth[THRUSTER_COUNT], servo[SERVO_COUNT > 0 ? SERVO_COUNT : 1];

/* --- transmitter: one train of pulses, all channels one after the other -------------------------------------------- */

static volatile uint16_t ppm_us[USV_RC_CHANNELS];
static volatile uint8_t ppm_channels = 0; /* of the last whole train; taken by the loop */

static void ppm_edge()
{
    static uint32_t last_us = 0;
    static uint8_t channel = USV_RC_CHANNELS + 1; /* nothing counts before the first gap */
    static uint16_t train_us[USV_RC_CHANNELS];
    const uint32_t now_us = micros();
    const uint32_t width_us = now_us - last_us;
    last_us = now_us;
    if (width_us >= PPM_GAP_US) {
        if (channel <= USV_RC_CHANNELS && channel > 0) {
            for (uint8_t i = 0; i < USV_RC_CHANNELS; i++) {
                ppm_us[i] = i < channel ? train_us[i] : 0;
            }
            ppm_channels = channel;
        }
        channel = 0;
    } else if (channel < USV_RC_CHANNELS) {
        train_us[channel++] = (uint16_t)width_us;
    }
}

static void read_ppm()
{
    noInterrupts();
    if (ppm_channels > 0) {
        board.in.rc_fresh = true;
        for (uint8_t i = 0; i < USV_RC_CHANNELS; i++) {
            board.in.rc_us[i] = ppm_us[i];
        }
        ppm_channels = 0;
    }
    interrupts();
}

/* --- transmitter: SBUS or CRSF on a serial port -------------------------------------------------------------------- */

#ifdef RC_PORT
static void read_rc_port(uint32_t now_ms)
{
    uint16_t us[USV_RC_CHANNELS];
    for (uint8_t i = 0; i < BYTES_PER_TURN && RC_PORT.available() > 0; i++) {
        if (usv_rc_hear(&receiver, (uint8_t)RC_PORT.read(), now_ms, us)) {
            board.in.rc_fresh = true;
            for (uint8_t j = 0; j < USV_RC_CHANNELS; j++) {
                board.in.rc_us[j] = us[j];
            }
        }
    }
}

/* A frame goes back whole or waits: writing must not hold the loop. */
static void write_rc_port()
{
    usv_radio &radio = board.out.radio;
    if (radio.length > 0 && RC_PROTOCOL == USV_RC_CRSF && RC_PORT.availableForWrite() >= (int)radio.length) {
        RC_PORT.write(radio.data, radio.length);
        radio.length = 0;
    }
}

static void start_rc_port()
{
    usv_rc_start(&receiver, RC_PROTOCOL);
    if (RC_PROTOCOL == USV_RC_SBUS) {
        RC_PORT.begin(100000, SERIAL_8E2);
    } else {
        RC_PORT.begin(CRSF_BAUD);
    }
}
#endif

static void start_transmitter()
{
    board.in.rc_present = RC_PROTOCOL != USV_RC_NONE;
    board.in.takes_radio = RC_PROTOCOL == USV_RC_CRSF;
    if (RC_PROTOCOL == USV_RC_PPM) {
        pinMode(PPM_PIN, INPUT);
        attachInterrupt(digitalPinToInterrupt(PPM_PIN), ppm_edge, RISING);
    }
#ifdef RC_PORT
    start_rc_port();
#endif
}

static void read_transmitter(uint32_t now_ms)
{
    if (RC_PROTOCOL == USV_RC_PPM) {
        read_ppm();
    }
#ifdef RC_PORT
    read_rc_port(now_ms);
    write_rc_port();
#else
    (void)now_ms;
#endif
}

/* --- sensors ------------------------------------------------------------------------------------------------------ */

static void read_sensors()
{
    board.in.leak_wet = LEAK_PIN != NO_PIN && digitalRead(LEAK_PIN) == LOW;
    if (VOLTAGE_PIN != NO_PIN) {
        board.in.battery_mv = (uint16_t)((uint32_t)analogRead(VOLTAGE_PIN) * VOLTAGE_FULL_MV / 1023U);
    }
    if (CURRENT_PIN != NO_PIN) {
        board.in.current_ma = (int32_t)analogRead(CURRENT_PIN) * CURRENT_FULL_MA / 1023 - CURRENT_ZERO_MA;
    }
    for (uint8_t i = 0; i < THRUSTER_COUNT; i++) {
        board.in.thruster[i].switch_up = UP_SWITCH_PIN[i] != NO_PIN && digitalRead(UP_SWITCH_PIN[i]) == LOW;
        board.in.thruster[i].switch_down = DOWN_SWITCH_PIN[i] != NO_PIN && digitalRead(DOWN_SWITCH_PIN[i]) == LOW;
    }
}

/* --- outputs ------------------------------------------------------------------------------------------------------ */

static void set_pin(uint8_t pin, bool high)
{
    if (pin != NO_PIN) {
        digitalWrite(pin, high ? HIGH : LOW);
    }
}

static void pulse(Servo &output, uint8_t pin, uint16_t us)
{
    if (us == 0) {
        output.detach();
    } else {
        if (!output.attached()) {
            output.attach(pin, USV_SHORTEST_US, USV_LONGEST_US);
        }
        output.writeMicroseconds((int)us);
    }
}

static void write_outputs()
{
    for (uint8_t i = 0; i < THRUSTER_COUNT; i++) {
        const usv_drive_output &out = board.out.thruster[i];
        pulse(throttle[i], THROTTLE_PIN[i], out.pulse_us);
        if (AZIMUTH_PIN[i] != NO_PIN) {
            pulse(azimuth[i], AZIMUTH_PIN[i], out.azimuth_us);
        }
        set_pin(LOWER_PIN[i], out.travel == USV_LOWER);
        set_pin(RAISE_PIN[i], out.travel == USV_RAISE);
    }
    for (uint8_t i = 0; i < SERVO_COUNT; i++) {
        pulse(servo[i], SERVO_PIN[i], board.out.auxiliary.servo_us[i]);
    }
    for (uint8_t i = 0; i < RELAY_COUNT; i++) {
        set_pin(RELAY_PIN[i], (board.out.auxiliary.relays >> i) & 1U);
    }
    set_pin(RED_PIN, board.out.red);
    set_pin(YELLOW_PIN, board.out.yellow);
    set_pin(GREEN_PIN, board.out.green);
}

/* A frame only goes out where there is room for it whole: writing must not wait for a host that does not read. */
static void speak(uint32_t now_ms)
{
    static uint8_t frame[USV_MAX_FRAME];
    static size_t length = 0, sent = 0;
    for (uint8_t turn = 0; turn < 4; turn++) {
        if (sent == length) {
            length = usv_board_speak(&board, now_ms, frame);
            sent = 0;
        }
        const int room = HOST.availableForWrite();
        if (length == 0 || room <= 0) {
            return;
        }
        const size_t some = (size_t)room < length - sent ? (size_t)room : length - sent;
        HOST.write(frame + sent, some);
        sent += some;
    }
}

void setup()
{
    usv_board_start(&board, &CONFIG, millis());
    write_outputs(); /* neutral before anything else */
    for (uint8_t i = 0; i < THRUSTER_COUNT; i++) {
        const uint8_t out_pins[] = {LOWER_PIN[i], RAISE_PIN[i]}, in_pins[] = {UP_SWITCH_PIN[i], DOWN_SWITCH_PIN[i]};
        for (uint8_t j = 0; j < 2; j++) {
            if (out_pins[j] != NO_PIN) {
                pinMode(out_pins[j], OUTPUT);
            }
            if (in_pins[j] != NO_PIN) {
                pinMode(in_pins[j], INPUT_PULLUP);
            }
        }
    }
    for (uint8_t i = 0; i < RELAY_COUNT; i++) {
        pinMode(RELAY_PIN[i], OUTPUT);
    }
    const uint8_t lamps[] = {RED_PIN, YELLOW_PIN, GREEN_PIN};
    for (uint8_t i = 0; i < 3; i++) {
        if (lamps[i] != NO_PIN) {
            pinMode(lamps[i], OUTPUT);
        }
    }
    if (LEAK_PIN != NO_PIN) {
        pinMode(LEAK_PIN, INPUT_PULLUP);
    }
    start_transmitter();
    HOST.begin(HOST_BAUD);
#ifdef __AVR__
    wdt_enable(WDTO_250MS);
#endif
}

void loop()
{
#ifdef __AVR__
    wdt_reset();
#endif
    const uint32_t now_ms = millis();
    for (uint8_t i = 0; i < BYTES_PER_TURN && HOST.available() > 0; i++) {
        usv_board_hear(&board, (uint8_t)HOST.read(), now_ms);
    }
    read_sensors();
    read_transmitter(now_ms);
    usv_board_step(&board, now_ms);
    write_outputs();
    speak(now_ms);
}
