/* SPDX-License-Identifier: MIT OR Apache-2.0
 *
 * The device's side of Calot's rig protocol, versions 1 and 2, for firmware in C99 or C++11.
 *
 * PROTOCOL.md documents every byte. This file needs no heap, no operating system and no library
 * beyond memcpy, memset and memcmp. It behaves like src/rig/device.rs; a test compares the two.
 *
 *     static calot_rig rig;                      once: calot_rig_init(&rig, &capabilities)
 *
 *     uint32_t now_us = micros();                in each cycle: read the clock once
 *     calot_rig_receive(&rig, bytes, n, now_us);      the bytes that the line has
 *     n = calot_rig_answer(&rig, out);                send n bytes, usually 0
 *     force = calot_rig_force(&rig, now_us);          drive the motors, in every cycle
 *     n = calot_rig_state(&rig, &motion, now_us, out);     once per sample: send n bytes
 *
 * The loop must never wait: a loop that hangs keeps the last force. Let the board's hardware
 * watchdog cut the motors then. Call all functions from one thread, none from an interrupt.
 *
 * Units are SI. The frame is the device's base: x right, y up, z to the user, seen from the user;
 * its origin is the middle of the workspace. `out` has room for CALOT_FRAME_MAX bytes. Send a frame
 * whole or not at all: after a part of a frame the host rejects the next frame too.
 */
#ifndef CALOT_RIG_H
#define CALOT_RIG_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

/* Version 2 adds the opening of the handle. A device without one speaks version 1. */
#define CALOT_VERSION 2
#define CALOT_PAYLOAD_MAX 60 /* longest payload, bytes */
#define CALOT_FRAME_MAX 66   /* longest frame with its closing zero, bytes */
#define CALOT_WATCHDOG_MAX_MS 100

/* Kinds of device. */
enum { CALOT_HAPTIC = 1, CALOT_PEDAL = 2 };
/* Bits of calot_motion.buttons. */
enum { CALOT_GRASP = 1, CALOT_CHANGE_INSTRUMENT = 2 };
/* Bits for calot_rig_switches. */
enum { CALOT_CUT = 1, CALOT_COAGULATE = 2, CALOT_HOLD_CAMERA = 4 };

/* The device as it describes itself. PROTOCOL.md has the ranges that the host accepts. A pedal sets
 * `kind`, `rate_hz`, `serial` and `name`, and leaves the rest zero. */
typedef struct {
    uint8_t kind;             /* CALOT_HAPTIC or CALOT_PEDAL */
    bool measures_velocity;   /* calot_motion.velocity_m_s is measured */
    uint8_t watchdog_ms;      /* the force drops after this time without a new FORCE: 1 to 100 */
    uint16_t rate_hz;         /* samples per second */
    float force_max_n;        /* peak of the magnitude. FORCE carries up to 32.767 N an axis */
    float force_continuous_n; /* the motors can hold it for ever */
    float stiffness_max_n_m;  /* largest stable stiffness, N/m */
    float damping_max_n_s_m;  /* largest damping that may be rendered, N s/m */
    float workspace_radius_m;
    float torque_max_n_m; /* peak torque, N m; 0 when the device renders none */
    float damping_n_s_m;  /* the mechanism's own damping, N s/m: measure it */
    float delay_s;        /* movement to sample plus command to force, s: measure it */
    uint32_t serial;
    const char *name; /* ASCII; 16 letters at most are sent */
    /* A handle that opens and shuts; zero without one. */
    float opening_travel_m;         /* travel of the fingers from shut to wide open */
    float opening_force_max_n;      /* peak force along it; 0 when the device renders none */
    float opening_stiffness_max_n_m; /* largest stable stiffness along it, N/m */
} calot_capabilities;

/* One sample of a haptic device. Start from calot_motion_zero(). */
typedef struct {
    float position_m[3];
    float velocity_m_s[3];  /* zero when it is not measured */
    float rotation_xyzw[4]; /* unit quaternion; 0 0 0 1 when it is not measured */
    uint8_t buttons;
    float opening; /* 0 shut to 1 wide open, finite; sent only if the device declares a travel */
} calot_motion;

/* A command for the motors: the force and the torque on the hand, and the force that opens the
 * handle. */
typedef struct {
    float force_n[3];
    float torque_n_m[3];
    float opening_n;
} calot_force;

/* One device. Firmware may read the first four fields; the others are private. */
typedef struct {
    bool streaming;          /* a host has greeted and not stopped */
    uint32_t messages;       /* messages understood; the counters wrap */
    uint32_t bad;            /* rejected frames and messages */
    uint32_t watchdog_trips; /* how often the watchdog dropped a force */
    calot_capabilities can;
    uint8_t bytes[CALOT_FRAME_MAX]; /* the incomplete frame */
    uint8_t length;
    bool overrun, answer_due, tripped, limited, fault, has_force, has_newest, says_opening;
    uint16_t sequence; /* number of the last message sent */
    uint16_t newest;   /* number of the newest FORCE; kept when the force is dropped */
    uint16_t command_sequence;
    uint32_t command_us;
    calot_force command;
} calot_rig;

/* ---- Numbers ---- */

/* Takes half a byte at a time, so that the table has 64 bytes instead of 1024. */
static inline uint32_t calot_crc32c(const uint8_t *bytes, size_t n)
{
    static const uint32_t table[16] = {
        0x00000000u, 0x105EC76Fu, 0x20BD8EDEu, 0x30E349B1u, 0x417B1DBCu, 0x5125DAD3u,
        0x61C69362u, 0x7198540Du, 0x82F63B78u, 0x92A8FC17u, 0xA24BB5A6u, 0xB21572C9u,
        0xC38D26C4u, 0xD3D3E1ABu, 0xE330A81Au, 0xF36E6F75u,
    };
    uint32_t crc = 0xFFFFFFFFu;
    for (size_t i = 0; i < n; i++) {
        crc ^= bytes[i];
        crc = (crc >> 4) ^ table[crc & 15u];
        crc = (crc >> 4) ^ table[crc & 15u];
    }
    return ~crc;
}

static inline uint16_t calot_read_u16(const uint8_t *at)
{
    return (uint16_t)(at[0] | (uint16_t)at[1] << 8);
}

static inline float calot_read_i16(const uint8_t *at, float unit)
{
    int32_t value = calot_read_u16(at);
    return (float)(value < 0x8000 ? value : value - 0x10000) * unit;
}

/* Writes a little-endian number and returns a pointer behind it. */
static inline uint8_t *calot_write(uint8_t *at, uint32_t value, unsigned bytes)
{
    for (; bytes > 0; bytes--) {
        *at++ = (uint8_t)value;
        value >>= 8;
    }
    return at;
}

/* Writes `value` in steps of `unit`, rounded half away from zero. It saturates at `least` and
 * `most`; a NaN becomes `least`. Returns a pointer behind the number. */
static inline uint8_t *calot_put(uint8_t *at, unsigned bytes, float value, float unit,
                                 int32_t least, int32_t most)
{
    float steps = value / unit;
    int32_t number;
    steps = steps < 0.0f ? steps - 0.5f : steps + 0.5f;
    if (!(steps > (float)least))
        number = least;
    else
        number = steps < (float)most ? (int32_t)steps : most;
    return calot_write(at, (uint32_t)number, bytes);
}

/* Tests the exponent's bits, because -ffast-math removes comparisons with NaN. */
static inline bool calot_is_finite(const float *values, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        uint32_t bits;
        memcpy(&bits, &values[i], sizeof bits);
        if ((bits & 0x7F800000u) == 0x7F800000u) return false;
    }
    return true;
}

/* Shortens a vector to a length of at most `max` and keeps its direction. */
static inline void calot_shorten(float vector[3], float max)
{
    float limit = max * max, ratio, scale = 0.0f;
    float squared = vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2];
    if (squared <= limit) return;
    ratio = limit > 0.0f ? squared / limit : 0.0f;
    if (ratio > 0.0f && calot_is_finite(&ratio, 1)) {
        /* 1/sqrt by Newton from the classic estimate: four steps reach the precision of a float. */
        uint32_t bits;
        memcpy(&bits, &ratio, sizeof bits);
        bits = 0x5F3759DFu - (bits >> 1);
        memcpy(&scale, &bits, sizeof scale);
        for (int step = 0; step < 4; step++) scale *= 1.5f - 0.5f * ratio * scale * scale;
    }
    for (int axis = 0; axis < 3; axis++) vector[axis] *= scale;
}

/* ---- Frames ---- */

/* Writes a payload of `n` bytes as a frame; behind the payload must be room for the checksum.
 * Returns the frame's length. */
static inline size_t calot_frame(uint8_t *payload, size_t n, uint8_t *out)
{
    size_t code_at = 0, length = 1;
    calot_write(payload + n, calot_crc32c(payload, n), 4);
    for (size_t i = 0; i < n + 4; i++) {
        if (payload[i] != 0) {
            out[length++] = payload[i];
        } else {
            out[code_at] = (uint8_t)(length - code_at);
            code_at = length++;
        }
    }
    out[code_at] = (uint8_t)(length - code_at);
    out[length++] = 0;
    return length;
}

/* Decodes the frame in `bytes` in place and checks the checksum. Returns the payload's length, or 0
 * if the bytes are no frame. */
static inline size_t calot_unframe(uint8_t *bytes, size_t length)
{
    size_t from = 0, to = 0;
    while (from < length) {
        size_t code = bytes[from], end = from + code;
        if (code == 0 || end > length) return 0;
        for (from++; from < end; from++) bytes[to++] = bytes[from];
        if (from < length) bytes[to++] = 0;
    }
    if (to < 5) return 0;
    to -= 4;
    uint32_t crc = calot_read_u16(bytes + to) | (uint32_t)calot_read_u16(bytes + to + 2) << 16;
    return crc == calot_crc32c(bytes, to) ? to : 0;
}

/* Begins a message with its kind and the next number. */
static inline uint8_t *calot_begin(calot_rig *rig, uint8_t *payload, uint8_t kind)
{
    rig->sequence++;
    return calot_write(calot_write(payload, kind, 1), rig->sequence, 2);
}

/* ---- The device ---- */

static inline calot_motion calot_motion_zero(void)
{
    calot_motion motion;
    memset(&motion, 0, sizeof motion);
    motion.rotation_xyzw[3] = 1.0f;
    motion.opening = 1.0f;
    return motion;
}

/* A device that no host has greeted. For a haptic device, a watchdog of 0 or more than 100 ms
 * becomes 100 ms. The caller must keep the name's text. */
static inline void calot_rig_init(calot_rig *rig, const calot_capabilities *capabilities)
{
    memset(rig, 0, sizeof *rig);
    rig->can = *capabilities;
    if (rig->can.kind == CALOT_HAPTIC
        && (rig->can.watchdog_ms == 0 || rig->can.watchdog_ms > CALOT_WATCHDOG_MAX_MS))
        rig->can.watchdog_ms = CALOT_WATCHDOG_MAX_MS;
}

static inline void calot_obey_force(calot_rig *rig, const uint8_t *payload, uint32_t now_us)
{
    uint16_t sequence = calot_read_u16(payload + 1);
    uint16_t step = (uint16_t)(sequence - rig->newest);
    if (!rig->streaming) return;
    /* A repeated or older number shows a stuck or reordering line, not a running host. */
    if (rig->has_newest && (step == 0 || step >= 0x8000u)) return;
    rig->has_newest = true;
    rig->newest = sequence;
    if (rig->fault) return;
    for (int axis = 0; axis < 3; axis++) {
        rig->command.force_n[axis] = calot_read_i16(payload + 3 + 2 * axis, 1e-3f);
        rig->command.torque_n_m[axis] = calot_read_i16(payload + 9 + 2 * axis, 1e-4f);
    }
    rig->command.opening_n = rig->says_opening ? calot_read_i16(payload + 15, 1e-3f) : 0.0f;
    rig->has_force = true;
    rig->command_sequence = sequence;
    rig->command_us = now_us;
    rig->tripped = false;
}

/* Returns false for a payload that is no message of a host. */
static inline bool calot_obey(calot_rig *rig, const uint8_t *payload, size_t n, uint32_t now_us)
{
    if (n == 9 && payload[0] == 0x01 && memcmp(payload + 3, "CALOT", 5) == 0) {
        /* A new host starts without the force of an earlier host. */
        rig->has_force = rig->has_newest = rig->tripped = false;
        rig->answer_due = rig->streaming = true;
        rig->says_opening = payload[8] >= 2 && rig->can.opening_travel_m > 0.0f;
    } else if (n == (rig->says_opening ? 17u : 15u) && payload[0] == 0x02) {
        calot_obey_force(rig, payload, now_us);
    } else if (n == 3 && payload[0] == 0x03) {
        rig->has_force = rig->streaming = false;
    } else {
        return false;
    }
    return true;
}

/* Takes `n` bytes from the host. `now_us` is the board's clock in microseconds. It may wrap, but it
 * must never run backwards between calls: a force from the future counts as too old. */
static inline void calot_rig_receive(calot_rig *rig, const uint8_t *bytes, size_t n,
                                     uint32_t now_us)
{
    for (size_t i = 0; i < n; i++) {
        size_t length = rig->length, payload;
        if (bytes[i] != 0) {
            if (length < CALOT_FRAME_MAX)
                rig->bytes[rig->length++] = bytes[i];
            else
                rig->overrun = true;
            continue;
        }
        if (length == 0) continue; /* Zeros between frames are allowed. */
        payload = rig->overrun ? 0 : calot_unframe(rig->bytes, length);
        rig->length = 0;
        rig->overrun = false;
        if (payload > 0 && calot_obey(rig, rig->bytes, payload, now_us))
            rig->messages++;
        else
            rig->bad++;
    }
}

/* Answer to a greeting, if one is due. Returns the number of bytes to send. */
static inline size_t calot_rig_answer(calot_rig *rig, uint8_t *out)
{
    const calot_capabilities *can = &rig->can;
    uint8_t payload[CALOT_PAYLOAD_MAX + 4], *at;
    if (!rig->answer_due) return 0;
    rig->answer_due = false;
    at = calot_begin(rig, payload, 0x81);
    at = calot_write(at, rig->says_opening ? CALOT_VERSION : 1, 1);
    at = calot_write(at, can->kind, 1);
    at = calot_write(at, can->measures_velocity ? 2 : 0, 1);
    at = calot_write(at, can->watchdog_ms, 1);
    at = calot_write(at, can->rate_hz, 2);
    at = calot_put(at, 2, can->force_max_n, 1e-3f, 0, 0xFFFF);
    at = calot_put(at, 2, can->force_continuous_n, 1e-3f, 0, 0xFFFF);
    at = calot_put(at, 2, can->stiffness_max_n_m, 1.0f, 0, 0xFFFF);
    at = calot_put(at, 2, can->damping_max_n_s_m, 1e-3f, 0, 0xFFFF);
    at = calot_put(at, 2, can->workspace_radius_m, 1e-4f, 0, 0xFFFF);
    at = calot_put(at, 2, can->torque_max_n_m, 1e-4f, 0, 0xFFFF);
    at = calot_put(at, 2, can->damping_n_s_m, 1e-3f, 0, 0xFFFF);
    at = calot_put(at, 2, can->delay_s, 1e-5f, 0, 0xFFFF);
    at = calot_write(at, can->serial, 4);
    memset(at, 0, 16);
    for (int i = 0; i < 16 && can->name && can->name[i]; i++) at[i] = (uint8_t)can->name[i];
    at += 16;
    if (rig->says_opening) {
        at = calot_put(at, 2, can->opening_travel_m, 1e-5f, 0, 0xFFFF);
        at = calot_put(at, 2, can->opening_force_max_n, 1e-3f, 0, 0xFFFF);
        at = calot_put(at, 2, can->opening_stiffness_max_n_m, 1.0f, 0, 0xFFFF);
    }
    return calot_frame(payload, (size_t)(at - payload), out);
}

/* Drops a force that is too old. The force must not stay stored: after a wrap of the clock it would
 * look new again. */
static inline void calot_watch(calot_rig *rig, uint32_t now_us)
{
    uint32_t age_us = (uint32_t)(now_us - rig->command_us);
    if (!rig->has_force || age_us <= (uint32_t)rig->can.watchdog_ms * 1000u) return;
    rig->has_force = false;
    rig->tripped = true;
    rig->watchdog_trips++;
}

/* Force for the motors now: the force in effect, shortened to the device's peak. Zero if none is in
 * effect: before a greeting, after STOP, at a fault, and after a watchdog's time without a new
 * FORCE. */
static inline calot_force calot_rig_force(calot_rig *rig, uint32_t now_us)
{
    calot_force force;
    memset(&force, 0, sizeof force);
    calot_watch(rig, now_us);
    if (rig->has_force) {
        force = rig->command;
        calot_shorten(force.force_n, rig->can.force_max_n);
        calot_shorten(force.torque_n_m, rig->can.torque_max_n_m);
        if (force.opening_n > rig->can.opening_force_max_n)
            force.opening_n = rig->can.opening_force_max_n;
        if (force.opening_n < -rig->can.opening_force_max_n)
            force.opening_n = -rig->can.opening_force_max_n;
    }
    return force;
}

/* One sample for the host. Returns the number of bytes to send: 0 before a greeting, after STOP,
 * and for a motion with a NaN or an infinity. The host counts such a sample as lost; many of them
 * end the force. A value beyond its field's range saturates; the host drops that sample. */
static inline size_t calot_rig_state(calot_rig *rig, const calot_motion *motion, uint32_t now_us,
                                     uint8_t *out)
{
    uint8_t payload[CALOT_PAYLOAD_MAX + 4], *at, status;
    if (!rig->streaming) return 0;
    calot_watch(rig, now_us);
    status = (uint8_t)(rig->has_force | rig->tripped << 1 | rig->limited << 2 | rig->fault << 3);
    at = calot_begin(rig, payload, 0x82);
    if (!calot_is_finite(motion->position_m, 3) || !calot_is_finite(motion->velocity_m_s, 3)
        || !calot_is_finite(motion->rotation_xyzw, 4)
        || (rig->says_opening && !calot_is_finite(&motion->opening, 1)))
        return 0;
    at = calot_write(at, status, 1);
    at = calot_write(at, motion->buttons, 1);
    at = calot_write(at, rig->has_force ? rig->command_sequence : 0u, 2);
    at = calot_write(at, now_us, 4);
    for (int i = 0; i < 3; i++)
        at = calot_put(at, 4, motion->position_m[i], 1e-7f, INT32_MIN, INT32_MAX);
    for (int i = 0; i < 3; i++)
        at = calot_put(at, 4, motion->velocity_m_s[i], 1e-6f, INT32_MIN, INT32_MAX);
    for (int i = 0; i < 4; i++)
        at = calot_put(at, 2, motion->rotation_xyzw[i], 1.0f / 32767.0f, -32768, 32767);
    if (rig->says_opening) at = calot_put(at, 2, motion->opening, 1.0f / 65535.0f, 0, 0xFFFF);
    return calot_frame(payload, (size_t)(at - payload), out);
}

/* One report of a pedal: the switches that are pressed, CALOT_CUT and so on. Returns the number of
 * bytes to send: 0 before a greeting and after STOP. */
static inline size_t calot_rig_switches(calot_rig *rig, uint8_t pressed, uint8_t *out)
{
    uint8_t payload[CALOT_PAYLOAD_MAX + 4], *at;
    if (!rig->streaming) return 0;
    at = calot_write(calot_begin(rig, payload, 0x83), pressed & 7u, 1);
    return calot_frame(payload, (size_t)(at - payload), out);
}

/* Reports, from the next sample on, whether heat or current limits the force. */
static inline void calot_rig_set_limited(calot_rig *rig, bool limited)
{
    rig->limited = limited;
}

/* Reports a fault that a person must repair. No force is in effect while the fault lasts. */
static inline void calot_rig_set_fault(calot_rig *rig, bool fault)
{
    rig->fault = fault;
    if (fault) rig->has_force = false;
}

#endif
