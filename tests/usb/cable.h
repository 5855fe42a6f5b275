/* SPDX-License-Identifier: Apache-2.0 */
/* cable.h: a simulated cable (firmware/usb/PIPE.md): the program between two ends that link_pipe.c makes. */
#ifndef TEST_USB_CABLE_H
#define TEST_USB_CABLE_H

#include <stdint.h>

struct cable;

/*
 * Listens at path for both ends, and at path.control for commands, a line each ("unplug", "replug", "lose-down", "suspend",
 * "resume", "throttle N"), each answered with "ok". NULL: it cannot.
 */
struct cable *cable_create(const char *path, uint64_t seed);

/* Until *stop is not 0; looks at it 20 times a second. */
void cable_run(struct cable *cable, const volatile int *stop);

void cable_destroy(struct cable *cable);

#endif
