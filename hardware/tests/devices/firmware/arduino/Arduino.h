/* As much of Arduino's functions as the sketches need, for a test without a board. Time passes with
 * each call of micros(). The serial line is standard input and output. */
#ifndef ARDUINO_H
#define ARDUINO_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

enum { LOW = 0, HIGH = 1, INPUT = 0, OUTPUT = 1 };

/* Arduino has these as macros. They break a header that uses the names. */
#define min(a, b) ((a) < (b) ? (a) : (b))
#define max(a, b) ((a) > (b) ? (a) : (b))
#define abs(x) ((x) > 0 ? (x) : -(x))
#define round(x) ((x) >= 0 ? (long)((x) + 0.5) : (long)((x)-0.5))
#define sq(x) ((x) * (x))
#define bit(b) (1UL << (b))

inline uint32_t micros()
{
    static uint32_t now_us = 0xFFFF0000u;
    return now_us += 100;
}

inline void pinMode(uint8_t, uint8_t) {}
inline void digitalWrite(uint8_t, uint8_t) {}
inline void analogWrite(uint8_t, int) {}
/* Teensyduino */
inline void analogWriteFrequency(uint8_t, float) {}
inline uint32_t analogWriteResolution(uint32_t bits) { return bits; }
/* arduino-pico */
inline void analogWriteFreq(uint32_t) {}
inline void analogWriteRange(uint32_t) {}

struct FakeSerial {
    int next = EOF;
    void begin(long) { next = getchar(); }
    int available() { return next == EOF ? 0 : 1; }
    int read()
    {
        const int byte = next;
        if (byte != EOF) next = getchar();
        return byte;
    }
    int availableForWrite() { return 64; }
    size_t write(const uint8_t *bytes, size_t n) { return fwrite(bytes, 1, n, stdout); }
    void flush() {}
    void send_now() {}
};
static FakeSerial Serial;

struct FakeChip {
    void wdt_begin(uint32_t) {}
    void wdt_reset() {}
};
static FakeChip rp2040 __attribute__((unused));

void setup();
void loop();

int main()
{
    setup();
    for (int round_ = 0; round_ < 5000; round_++) loop();
    return 0;
}

#endif
