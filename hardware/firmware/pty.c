/* A rig without hardware: this program speaks the rig protocol through a pty. It serves for trying
 * Calot and for the tests of calot_rig.h. It runs on Linux.
 *
 *     cc -std=c99 -O2 -o pty hardware/firmware/pty.c
 *     ./pty /tmp/my-rig
 *     calot devices conformance /tmp/my-rig
 *
 * --fault adds a mistake to the firmware, so that one can see what Calot reports.
 */
#define _DEFAULT_SOURCE
#define _XOPEN_SOURCE 700

#include "calot_rig.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

static const char HELP[] =
    "usage: pty [--pedal] [--still] [--fault NAME[=NUMBER]]... PATH\n"
    "\n"
    "Makes a pty, links PATH to it, and behaves as a haptic device of 1 kHz until Ctrl-C. The\n"
    "handle moves in a small circle. The program prints the pty's path when it is ready.\n"
    "\n"
    "  --pedal  a foot pedal of 100 Hz that nobody presses\n"
    "  --still  the handle rests in the middle\n"
    "  --fault  a mistake of the firmware; several may be given:\n";

/* Mistakes of firmware, in the order of NAMES. */
enum fault {
    WRONG_CRC, NO_ZERO, SHORT_CAPABILITIES, SLOW_BOOT, NO_WATCHDOG, SLOW_WATCHDOG, NO_STOP, DEAF,
    FORCE_STATUS, FROZEN_CLOCK, CLOCK_MS, FROZEN_HANDLE, NOT_A_NUMBER, FAR, LEAP, NO_ROTATION,
    STUCK_NUMBER, SLOW, LIMITED, FAULT, FAULTS
};

static const struct {
    const char *name;
    long usual; /* number for a fault without =NUMBER */
    const char *meaning;
} NAMES[FAULTS] = {
    {"wrong-crc", 1, "every checksum is wrong"},
    {"no-zero", 1, "no frame ends with a zero"},
    {"short-capabilities", 1, "CAPABILITIES lacks its last NUMBER bytes"},
    {"slow-boot", 3, "bytes are ignored for NUMBER seconds from the host's first ones on"},
    {"no-watchdog", 1, "the force never drops"},
    {"slow-watchdog", 150, "the force drops after NUMBER ms; 50 are declared"},
    {"no-stop", 1, "samples go on after STOP"},
    {"deaf", 1, "every FORCE is ignored"},
    {"force-status", 1, "status bit 0 is clear for a FORCE of zero"},
    {"frozen-clock", 1, "the clock stands still"},
    {"clock-ms", 1, "the clock counts ms"},
    {"frozen-handle", 1, "the position stands still while the velocity is not zero"},
    {"nan", 10, "one of NUMBER positions is not a number"},
    {"far", 150, "the handle is NUMBER mm from the middle; the workspace has 100"},
    {"leap", 100, "one of NUMBER positions is off by 50 mm"},
    {"no-rotation", 1, "the rotation is 0 0 0 0"},
    {"stuck-number", 1, "every message has number 1"},
    {"slow", 250, "NUMBER samples per second; 1000 are declared"},
    {"limited", 1, "status bit 2: heat or current limits the force"},
    {"fault", 1, "status bit 3: a person must repair the device"},
};

static struct {
    bool pedal, still;
    long faults[FAULTS]; /* 0: the firmware does not make this mistake */
    const char *path;
} options;

static volatile sig_atomic_t is_over;

static void end(int signal)
{
    (void)signal;
    is_over = 1;
}

static void fail(const char *doing)
{
    fprintf(stderr, "pty: %s: %s\n", doing, strerror(errno));
    exit(1);
}

static void help(FILE *out)
{
    fputs(HELP, out);
    for (int i = 0; i < FAULTS; i++) {
        char name[32];
        if (NAMES[i].usual > 1)
            snprintf(name, sizeof name, "%s=%ld", NAMES[i].name, NAMES[i].usual);
        else
            snprintf(name, sizeof name, "%s", NAMES[i].name);
        fprintf(out, "             %-20s %s\n", name, NAMES[i].meaning);
    }
}

static void usage(const char *wrong)
{
    fprintf(stderr, "pty: '%s' is not understood\n\n", wrong);
    help(stderr);
    exit(2);
}

static void read_fault(const char *text)
{
    size_t length = strcspn(text, "=");
    for (int i = 0; i < FAULTS; i++) {
        if (strlen(NAMES[i].name) != length || strncmp(NAMES[i].name, text, length) != 0) continue;
        options.faults[i] = text[length] ? strtol(text + length + 1, NULL, 10) : NAMES[i].usual;
        if (options.faults[i] <= 0) usage(text);
        return;
    }
    usage(text);
}

static void read_options(int count, char **words)
{
    for (int i = 1; i < count; i++) {
        if (strcmp(words[i], "--help") == 0) {
            help(stdout);
            exit(0);
        } else if (strcmp(words[i], "--pedal") == 0)
            options.pedal = true;
        else if (strcmp(words[i], "--still") == 0)
            options.still = true;
        else if (strcmp(words[i], "--fault") == 0 && i + 1 < count)
            read_fault(words[++i]);
        else if (words[i][0] == '-' || options.path)
            usage(words[i]);
        else
            options.path = words[i];
    }
    if (!options.path) usage("no PATH");
}

/* Opens the pty and returns its master. The slave stays open, so that raw mode outlives a host. */
static int open_line(void)
{
    struct termios raw;
    int slave, master = posix_openpt(O_RDWR | O_NOCTTY);
    const char *name;
    char letter;
    if (master < 0 || grantpt(master) || unlockpt(master)) fail("making a pty");
    name = ptsname(master);
    slave = name ? open(name, O_RDWR | O_NOCTTY) : -1;
    if (slave < 0 || tcgetattr(slave, &raw)) fail("opening the pty");
    cfmakeraw(&raw);
    if (tcsetattr(slave, TCSANOW, &raw)) fail("setting the pty to raw");
    if (fcntl(master, F_SETFL, O_NONBLOCK)) fail("setting the pty to return at once");
    /* Removes the link of an earlier run, but never a file. */
    if (readlink(options.path, &letter, 1) >= 0) unlink(options.path);
    if (symlink(name, options.path)) fail(options.path);
    printf("%s\n", name);
    fflush(stdout);
    return master;
}

static uint64_t clock_us(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000u + (uint64_t)now.tv_nsec / 1000u;
}

static calot_capabilities describe(void)
{
    calot_capabilities can;
    memset(&can, 0, sizeof can);
    can.kind = options.pedal ? CALOT_PEDAL : CALOT_HAPTIC;
    can.rate_hz = options.pedal ? 100 : 1000;
    can.serial = 3;
    can.name = options.pedal ? "pedal in C" : "rig in C";
    if (options.pedal) return can;
    can.measures_velocity = true;
    can.watchdog_ms = 50;
    can.force_max_n = 3.0f;
    can.force_continuous_n = 1.0f;
    can.stiffness_max_n_m = 700.0f;
    can.damping_max_n_s_m = 5.0f;
    can.workspace_radius_m = 0.1f;
    can.damping_n_s_m = 1.0f;
    can.delay_s = 0.002f;
    return can;
}

/* Moves the handle for `passed_s` along a circle with a radius of 10 mm, at 10 mm/s. It rotates a
 * vector, because libm's sine is not linked. */
static calot_motion move(double passed_s)
{
    static double x_m = 0.01, y_m = 0.0;
    static long sample;
    calot_motion motion = calot_motion_zero();
    double grown;
    sample++;
    if (!options.still) {
        x_m -= y_m * passed_s;
        y_m += x_m * passed_s;
        /* One Newton step restores the radius. */
        grown = (x_m * x_m + y_m * y_m) / 1e-4;
        x_m *= 1.5 - 0.5 * grown;
        y_m *= 1.5 - 0.5 * grown;
        motion.position_m[0] = (float)x_m;
        motion.position_m[1] = (float)y_m;
        motion.velocity_m_s[0] = (float)-y_m;
        motion.velocity_m_s[1] = (float)x_m;
    }
    if (options.faults[FROZEN_HANDLE]) {
        memset(motion.position_m, 0, sizeof motion.position_m);
        motion.velocity_m_s[0] = 0.1f;
    }
    if (options.faults[FAR]) motion.position_m[2] = (float)options.faults[FAR] * 1e-3f;
    if (options.faults[LEAP] && sample % options.faults[LEAP] == 0) motion.position_m[2] += 0.05f;
    if (options.faults[NOT_A_NUMBER] && sample % options.faults[NOT_A_NUMBER] == 0) {
        const uint32_t bits = 0x7FC00000u;
        memcpy(&motion.position_m[0], &bits, sizeof bits);
    }
    if (options.faults[NO_ROTATION]) motion.rotation_xyzw[3] = 0.0f;
    return motion;
}

/* Adds the chosen mistakes to a frame. Returns its new length. */
static size_t spoil(calot_rig *rig, uint8_t *frame, size_t n)
{
    uint8_t payload[CALOT_FRAME_MAX];
    size_t length;
    memcpy(payload, frame, n);
    length = calot_unframe(payload, n - 1);
    if (options.faults[SHORT_CAPABILITIES] && payload[0] == 0x81) {
        long less = options.faults[SHORT_CAPABILITIES];
        length -= less < 40 ? (size_t)less : 40;
    }
    if (options.faults[STUCK_NUMBER]) calot_write(payload + 1, 1, 2);
    if (options.faults[FROZEN_CLOCK] && payload[0] == 0x82) calot_write(payload + 7, 0, 4);
    if (options.faults[CLOCK_MS] && payload[0] == 0x82) {
        uint32_t us = calot_read_u16(payload + 7) | (uint32_t)calot_read_u16(payload + 9) << 16;
        calot_write(payload + 7, us / 1000u, 4);
    }
    if (options.faults[FORCE_STATUS] && payload[0] == 0x82) {
        const float *force_n = rig->command.force_n;
        if (!(force_n[0] != 0.0f || force_n[1] != 0.0f || force_n[2] != 0.0f)) payload[3] &= 0xFE;
    }
    n = calot_frame(payload, length, frame);
    if (options.faults[WRONG_CRC]) frame[n - 2] = (uint8_t)(frame[n - 2] == 1 ? 2 : 1);
    return options.faults[NO_ZERO] ? n - 1 : n;
}

/* Sends a frame whole or not at all. A host that does not read loses the frame. */
static void transmit(calot_rig *rig, int line, uint8_t *frame, size_t n)
{
    if (n == 0) return;
    n = spoil(rig, frame, n);
    if (write(line, frame, n) < 0 && errno != EAGAIN && errno != EIO) fail("writing to the pty");
}

/* Reads the bytes that have come. A booting board ignores them. */
static void hear(calot_rig *rig, int line, uint64_t now, uint32_t now_us)
{
    static uint64_t boot_until;
    uint8_t bytes[256];
    ssize_t n;
    while ((n = read(line, bytes, sizeof bytes)) > 0) {
        bool was_streaming = rig->streaming;
        uint32_t messages = rig->messages;
        if (options.faults[SLOW_BOOT] && !was_streaming) {
            if (boot_until == 0) boot_until = now + (uint64_t)options.faults[SLOW_BOOT] * 1000000u;
            if (now < boot_until) continue;
        }
        calot_rig_receive(rig, bytes, (size_t)n, now_us);
        if (options.faults[DEAF] && rig->messages != messages) rig->has_force = false;
        if (was_streaming && !rig->streaming) {
            boot_until = 0;
            rig->streaming = options.faults[NO_STOP] != 0;
        }
    }
}

/* Lets a force last longer, as the mistakes of the watchdog demand: renews its time. */
static void watch_wrongly(calot_rig *rig, uint32_t now_us)
{
    static uint32_t command_us;
    static uint16_t number;
    if (rig->has_force && rig->command_sequence != number) {
        number = rig->command_sequence;
        command_us = rig->command_us;
    }
    /* The rig's own watchdog then drops the force after its own time. */
    long held_us = options.faults[SLOW_WATCHDOG] * 1000 - rig->can.watchdog_ms * 1000;
    if (options.faults[NO_WATCHDOG] || (long)(now_us - command_us) < held_us)
        rig->command_us = now_us;
}

static void run(int line)
{
    static calot_rig rig;
    uint8_t frame[CALOT_FRAME_MAX];
    const calot_capabilities can = describe();
    const long rate_hz = options.faults[SLOW] ? options.faults[SLOW] : can.rate_hz;
    const uint64_t start = clock_us(), period_us = 1000000u / (uint64_t)rate_hz;
    uint64_t due = start, sampled = start;
    calot_rig_init(&rig, &can);
    calot_rig_set_limited(&rig, options.faults[LIMITED] != 0);
    calot_rig_set_fault(&rig, options.faults[FAULT] != 0);
    while (!is_over) {
        const struct timespec pause = {0, 250000};
        uint64_t now = clock_us();
        uint32_t now_us = (uint32_t)(now - start);
        hear(&rig, line, now, now_us);
        transmit(&rig, line, frame, calot_rig_answer(&rig, frame));
        watch_wrongly(&rig, now_us);
        calot_rig_force(&rig, now_us); /* There are no motors. */
        if (now >= due) {
            calot_motion motion = move((double)(now - sampled) * 1e-6);
            size_t n = options.pedal ? calot_rig_switches(&rig, 0, frame)
                                     : calot_rig_state(&rig, &motion, now_us, frame);
            transmit(&rig, line, frame, n);
            sampled = now;
            /* A late program skips samples, as a board does, and sends no bundles. */
            due = due + period_us > now ? due + period_us : now + period_us;
        }
        nanosleep(&pause, NULL);
    }
}

int main(int count, char **words)
{
    int line;
    read_options(count, words);
    line = open_line();
    signal(SIGINT, end);
    signal(SIGTERM, end);
    run(line);
    unlink(options.path);
    return 0;
}
