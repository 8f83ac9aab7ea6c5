/* What the sketch uses of Arduino, as far as a compiler needs it. */
#pragma once
#include <stddef.h>
#include <stdint.h>

enum { LOW, HIGH, INPUT, OUTPUT, INPUT_PULLUP, RISING };
const uint8_t A0 = 54, A1 = 55, SERIAL_8E2 = 0x2E;

uint32_t millis();
uint32_t micros();
void noInterrupts();
void interrupts();
void pinMode(uint8_t pin, uint8_t mode);
void digitalWrite(uint8_t pin, uint8_t value);
int digitalRead(uint8_t pin);
int analogRead(uint8_t pin);
int digitalPinToInterrupt(uint8_t pin);
void attachInterrupt(int interrupt, void (*handler)(), int mode);

struct HardwareSerial {
    void begin(unsigned long baud);
    void begin(unsigned long baud, uint8_t format);
    int available();
    int read();
    int availableForWrite();
    size_t write(const uint8_t *data, size_t length);
};
extern HardwareSerial Serial, Serial1;
