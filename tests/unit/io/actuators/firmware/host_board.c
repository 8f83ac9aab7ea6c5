/*
 * The board as a process: host_board FD, its serial line a descriptor it inherits, its clock the monotonic one.
 *
 * stdin takes lines for what the board measures: "leak 1", "battery MV MA REMAINING", "rc US×8", "norc", "switch up|down|none".
 * stdout says, stamped with the board's own clock in ms:
 *     MS heard SEQUENCE                          a valid COMMAND
 *     MS out PULSE0 PULSE1 … | AZIMUTH0 … | MS   whenever an output moves; at the end, when it last looked before
 *     MS lamps RED YELLOW GREEN                  whenever one changes
 */
#define _POSIX_C_SOURCE 200809L
#include "usv_board.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#define STERN {.trim_us = 1500, .ahead_us = 1900, .astern_us = 1100, .azimuth = USV_ENDLESS, .azimuth_rate = 26180}

static const usv_drive_config THRUSTERS[3] = {
    STERN,
    STERN,
    {.trim_us = 1520, .ahead_us = 1920, .astern_us = 1080, .dead_us = 20, .reversed = true, .azimuth_rest = 15708, .travel_ms = 300, .end_switches = true},
};
static const usv_board_config CONFIG = {.name = "host board", .thrusters = 3, .relays = 2, .servos = 1, .thruster = THRUSTERS};

static usv_board board;

static uint32_t now_ms(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint32_t)((uint64_t)now.tv_sec * 1000U + (uint64_t)now.tv_nsec / 1000000U);
}

static void take_line(char *line)
{
    unsigned us[USV_RC_CHANNELS];
    unsigned mv = 0, remaining = 0, wet = 0;
    long ma = 0;
    if (sscanf(line, "leak %u", &wet) == 1) {
        board.in.leak_wet = wet != 0;
    } else if (sscanf(line, "battery %u %ld %u", &mv, &ma, &remaining) == 3) {
        board.in.battery_mv = (uint16_t)mv;
        board.in.current_ma = (int32_t)ma;
        board.in.remaining = (uint8_t)remaining;
    } else if (sscanf(line, "rc %u %u %u %u %u %u %u %u", us, us + 1, us + 2, us + 3, us + 4, us + 5, us + 6, us + 7) == USV_RC_CHANNELS) {
        board.in.rc_present = board.in.rc_fresh = true;
        for (int i = 0; i < USV_RC_CHANNELS; i++) {
            board.in.rc_us[i] = (uint16_t)us[i];
        }
    } else if (strncmp(line, "norc", 4) == 0) {
        board.in.rc_present = false;
    } else if (strncmp(line, "switch", 6) == 0) {
        board.in.thruster[2].switch_up = strncmp(line + 7, "up", 2) == 0;
        board.in.thruster[2].switch_down = strncmp(line + 7, "down", 4) == 0;
    }
}

static void take_lines(void)
{
    static char line[256];
    static size_t length = 0;
    char c;
    while (read(0, &c, 1) == 1) {
        if (c == '\n') {
            line[length] = '\0';
            take_line(line);
            length = 0;
        } else if (length < sizeof line - 1) {
            line[length++] = c;
        }
    }
}

static void tell(uint32_t ms, uint32_t last_ms, const usv_board_out *before)
{
    bool moved = false;
    for (int i = 0; i < 3; i++) {
        moved = moved || before->thruster[i].pulse_us != board.out.thruster[i].pulse_us || before->thruster[i].azimuth != board.out.thruster[i].azimuth;
    }
    if (moved) {
        printf("%lu out", (unsigned long)ms);
        for (int i = 0; i < 3; i++) {
            printf(" %u", board.out.thruster[i].pulse_us);
        }
        printf(" |");
        for (int i = 0; i < 3; i++) {
            printf(" %ld", (long)board.out.thruster[i].azimuth);
        }
        printf(" | %lu\n", (unsigned long)last_ms);
    }
    if (before->red != board.out.red || before->yellow != board.out.yellow || before->green != board.out.green) {
        printf("%lu lamps %d %d %d\n", (unsigned long)ms, board.out.red, board.out.yellow, board.out.green);
    }
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        return 2;
    }
    const int line = atoi(argv[1]);
    uint8_t bytes[256], frame[USV_MAX_FRAME];
    fcntl(line, F_SETFL, O_NONBLOCK);
    fcntl(0, F_SETFL, O_NONBLOCK);
    setvbuf(stdout, NULL, _IOLBF, 0);
    usv_board_start(&board, &CONFIG, now_ms());
    board.in.thruster[2].switch_down = true;
    for (;;) {
        struct pollfd waiting = {line, POLLIN, 0};
        poll(&waiting, 1, 1);
        const uint32_t ms = now_ms();
        const ssize_t n = read(line, bytes, sizeof bytes);
        const uint32_t heard_ms = board.commanded_ms;
        const uint8_t heard = board.command.sequence;
        for (ssize_t i = 0; i < n; i++) {
            usv_board_hear(&board, bytes[i], ms);
        }
        if (n < 0 && errno == EIO) { /* nobody has the other end open */
            const struct timespec moment = {0, 1000000};
            nanosleep(&moment, NULL);
        }
        if (board.commanded_ms != heard_ms || board.command.sequence != heard) {
            printf("%lu heard %u\n", (unsigned long)ms, board.command.sequence);
        }
        take_lines();
        const usv_board_out before = board.out;
        const uint32_t last_ms = board.stepped_ms;
        usv_board_step(&board, ms);
        tell(ms, last_ms, &before);
        for (size_t length = usv_board_speak(&board, ms, frame); length > 0; length = usv_board_speak(&board, ms, frame)) {
            if (write(line, frame, length) < 0) {
                break; /* nobody listens */
            }
        }
    }
}
