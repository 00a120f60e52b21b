/* calot_rig.h as a shared library, so that a test can compare it with the device in Rust. It is
 * compiled as C and as C++. */
#include "calot_rig.h"

#ifdef __cplusplus
#define EXPORTED extern "C"
#else
#define EXPORTED
#endif

typedef struct {
    calot_rig rig;
    char name[17];
} twin;

EXPORTED size_t twin_size(void);
EXPORTED uint32_t twin_crc(const uint8_t *bytes, size_t n);
EXPORTED void twin_init(twin *it, uint8_t kind, uint8_t watchdog_ms, uint16_t rate_hz,
                        uint32_t serial, const char *name, const float *figures);
EXPORTED void twin_receive(twin *it, const uint8_t *bytes, size_t n, uint32_t now_us);
EXPORTED size_t twin_answer(twin *it, uint8_t *out);
EXPORTED void twin_force(twin *it, uint32_t now_us, float *out);
EXPORTED size_t twin_state(twin *it, const float *motion, uint8_t buttons, uint32_t now_us,
                           uint8_t *out);
EXPORTED size_t twin_switches(twin *it, uint8_t pressed, uint8_t *out);
EXPORTED void twin_report(twin *it, uint8_t limited, uint8_t fault);
EXPORTED void twin_counters(const twin *it, uint32_t *out);

size_t twin_size(void)
{
    return sizeof(twin);
}

uint32_t twin_crc(const uint8_t *bytes, size_t n)
{
    return calot_crc32c(bytes, n);
}

void twin_init(twin *it, uint8_t kind, uint8_t watchdog_ms, uint16_t rate_hz, uint32_t serial,
               const char *name, const float *figures)
{
    calot_capabilities can;
    memset(&can, 0, sizeof can);
    memcpy(it->name, name, sizeof it->name);
    can.kind = kind;
    can.measures_velocity = kind == CALOT_HAPTIC;
    can.watchdog_ms = watchdog_ms;
    can.rate_hz = rate_hz;
    can.force_max_n = figures[0];
    can.force_continuous_n = figures[1];
    can.stiffness_max_n_m = figures[2];
    can.damping_max_n_s_m = figures[3];
    can.workspace_radius_m = figures[4];
    can.torque_max_n_m = figures[5];
    can.damping_n_s_m = figures[6];
    can.delay_s = figures[7];
    can.opening_travel_m = figures[8];
    can.opening_force_max_n = figures[9];
    can.opening_stiffness_max_n_m = figures[10];
    can.serial = serial;
    can.name = it->name;
    calot_rig_init(&it->rig, &can);
}

void twin_receive(twin *it, const uint8_t *bytes, size_t n, uint32_t now_us)
{
    calot_rig_receive(&it->rig, bytes, n, now_us);
}

size_t twin_answer(twin *it, uint8_t *out)
{
    return calot_rig_answer(&it->rig, out);
}

void twin_force(twin *it, uint32_t now_us, float *out)
{
    const calot_force force = calot_rig_force(&it->rig, now_us);
    memcpy(out, force.force_n, sizeof force.force_n);
    memcpy(out + 3, force.torque_n_m, sizeof force.torque_n_m);
    out[6] = force.opening_n;
}

size_t twin_state(twin *it, const float *motion, uint8_t buttons, uint32_t now_us, uint8_t *out)
{
    calot_motion moved = calot_motion_zero();
    memcpy(moved.position_m, motion, sizeof moved.position_m);
    memcpy(moved.velocity_m_s, motion + 3, sizeof moved.velocity_m_s);
    memcpy(moved.rotation_xyzw, motion + 6, sizeof moved.rotation_xyzw);
    moved.buttons = buttons;
    moved.opening = motion[10];
    return calot_rig_state(&it->rig, &moved, now_us, out);
}

size_t twin_switches(twin *it, uint8_t pressed, uint8_t *out)
{
    return calot_rig_switches(&it->rig, pressed, out);
}

void twin_report(twin *it, uint8_t limited, uint8_t fault)
{
    calot_rig_set_limited(&it->rig, limited != 0);
    calot_rig_set_fault(&it->rig, fault != 0);
}

void twin_counters(const twin *it, uint32_t *out)
{
    out[0] = it->rig.messages;
    out[1] = it->rig.bad;
    out[2] = it->rig.watchdog_trips;
}
