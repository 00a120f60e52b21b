/* Firmware of a haptic device on a Teensy 4: three encoders, three motors, USB serial.
 *
 * Copy calot_rig.h into this folder, choose Tools > USB Type > Serial, and write the parts marked
 * YOURS. As it stands, the handle rests in the middle and the motors get no power.
 * A test compiles this sketch against a stand-in of Arduino.h. It has not run on a board yet.
 */
#include <Arduino.h>

#include "calot_rig.h"

/* YOURS: pins, and the constants of the mechanism. */
static const uint8_t ENABLE_PIN = 2; /* with a pull-down: no force while the board resets */
static const uint8_t PWM_PINS[3] = {3, 4, 5};
static const uint8_t DIRECTION_PINS[3] = {6, 7, 8};
static const float M_PER_COUNT[3] = {1e-5f, 1e-5f, 1e-5f};
static const float FULL_FORCE_N[3] = {3.0f, 3.0f, 3.0f}; /* force at full PWM */
static const bool MOTORS_ARE_READY = false; /* true once signs and constants are measured */

static const uint32_t PERIOD_US = 1000;
static const float PWM_MAX = 4095.0f;

static calot_rig rig;
static uint32_t due_us; /* time of the next sample */

/* YOURS: the device's capabilities. Measure these values, do not guess them. */
static calot_capabilities describe()
{
    calot_capabilities can;
    memset(&can, 0, sizeof can);
    can.kind = CALOT_HAPTIC;
    can.watchdog_ms = 50;
    can.rate_hz = 1000000 / PERIOD_US;
    can.force_max_n = 3.0f;
    can.force_continuous_n = 0.8f;
    can.stiffness_max_n_m = 500.0f;
    can.damping_max_n_s_m = 2.0f;
    can.workspace_radius_m = 0.1f;
    can.damping_n_s_m = 0.2f;
    can.delay_s = 0.003f;
    can.serial = 1;
    can.name = "teensy rig";
    return can;
}

/* YOURS: the count of one encoder, 0 in the middle of the workspace. The libraries QuadEncoder and
 * Encoder read encoders. */
static int32_t encoder(int axis)
{
    (void)axis;
    return 0;
}

/* YOURS: the linkage. These three axes are linear and at right angles. For an arm,
 * compute the position of its end: x right, y up, z to the user. */
static calot_motion measure()
{
    calot_motion motion = calot_motion_zero();
    for (int axis = 0; axis < 3; axis++)
        motion.position_m[axis] = (float)encoder(axis) * M_PER_COUNT[axis];
    return motion;
}

/* YOURS: the motors. For an arm, multiply with the transpose of its Jacobian. A positive force
 * moves the handle to positive positions: check each axis with a spring balance before a hand holds
 * the device. */
static void drive(const calot_force &force)
{
    digitalWrite(ENABLE_PIN, MOTORS_ARE_READY && rig.streaming ? HIGH : LOW);
    for (int axis = 0; axis < 3; axis++) {
        float share = force.force_n[axis] / FULL_FORCE_N[axis];
        bool is_negative = share < 0.0f;
        if (is_negative) share = -share;
        if (share > 1.0f) share = 1.0f;
        digitalWrite(DIRECTION_PINS[axis], is_negative ? LOW : HIGH);
        analogWrite(PWM_PINS[axis], MOTORS_ARE_READY ? (int)(share * PWM_MAX) : 0);
    }
}

/* Sends a frame whole or not at all, so that the loop never waits for a host that does not read. */
static void transmit(const uint8_t *frame, size_t n)
{
    if (n > 0 && Serial.availableForWrite() >= (int)n) {
        Serial.write(frame, n);
        Serial.send_now();
    }
}

void setup()
{
    const calot_capabilities can = describe();
    pinMode(ENABLE_PIN, OUTPUT);
    digitalWrite(ENABLE_PIN, LOW);
    analogWriteResolution(12);
    for (int axis = 0; axis < 3; axis++) {
        pinMode(DIRECTION_PINS[axis], OUTPUT);
        pinMode(PWM_PINS[axis], OUTPUT);
        analogWriteFrequency(PWM_PINS[axis], 30000);
        analogWrite(PWM_PINS[axis], 0);
    }
    Serial.begin(1000000); /* USB ignores the rate. */
    calot_rig_init(&rig, &can);
    due_us = micros();
    /* YOURS: start the hardware watchdog (library WDT_T4), and feed it in loop(). */
}

void loop()
{
    uint8_t bytes[64], frame[CALOT_FRAME_MAX];
    size_t n = 0;
    const uint32_t now_us = micros();
    while (n < sizeof bytes && Serial.available() > 0) bytes[n++] = (uint8_t)Serial.read();
    calot_rig_receive(&rig, bytes, n, now_us);
    transmit(frame, calot_rig_answer(&rig, frame));
    drive(calot_rig_force(&rig, now_us));
    if ((int32_t)(now_us - due_us) >= 0) {
        const calot_motion motion = measure();
        transmit(frame, calot_rig_state(&rig, &motion, now_us, frame));
        due_us += PERIOD_US;
        if ((int32_t)(now_us - due_us) >= 0) due_us = now_us + PERIOD_US;
    }
}
