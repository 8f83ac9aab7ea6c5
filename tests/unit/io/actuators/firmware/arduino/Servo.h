#pragma once
#include <stdint.h>

struct Servo {
    uint8_t attach(int pin, int min_us, int max_us);
    void detach();
    bool attached();
    void writeMicroseconds(int us);
};
