/* SPDX-License-Identifier: Apache-2.0 */
/* cable_main.c: a simulated cable as a program: usb_cable PATH [SEED]. Ends on SIGTERM. */
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>

#include "cable.h"

static volatile int stop;

static void on_stop(int number)
{
    (void)number;
    stop = 1;
}

int main(int argc, char **argv)
{
    struct sigaction action = {.sa_handler = on_stop};
    struct cable *cable =
        argc >= 2 ? cable_create(argv[1], argc > 2 ? strtoull(argv[2], NULL, 10) : 1) : NULL;

    if (!cable) {
        (void)fprintf(stderr, "usage: %s PATH [SEED]\n", argv[0]);
        return 2;
    }
    (void)sigaction(SIGTERM, &action, NULL);
    (void)sigaction(SIGINT, &action, NULL);
    (void)printf("ready\n");
    (void)fflush(stdout);
    cable_run(cable, &stop);
    cable_destroy(cable);
    return 0;
}
