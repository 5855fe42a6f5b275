/* SPDX-License-Identifier: Apache-2.0 */
/*
 * strike CHIP LINE SIGNAL PID: raises a line, sends the signal, lets the line fall. The outside observer sees when, and
 * nothing lies between mark and stroke but this program: of a shell, the mark would be older by the end of one program.
 */
#include <fcntl.h>
#include <linux/gpio.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <unistd.h>

/* The line as an output that is high, or -1. */
static int raise_line(const char *chip, unsigned line)
{
    struct gpio_v2_line_request request = {
        .offsets = {line},
        .num_lines = 1,
        .consumer = "strike",
        .config = {.flags = GPIO_V2_LINE_FLAG_OUTPUT,
                   .num_attrs = 1,
                   .attrs = {{.attr = {.id = GPIO_V2_LINE_ATTR_ID_OUTPUT_VALUES, .values = 1},
                              .mask = 1}}}};
    int fd = open(chip, O_RDWR | O_CLOEXEC);

    if (fd < 0 || ioctl(fd, GPIO_V2_GET_LINE_IOCTL, &request) < 0)
        return -1;
    (void)close(fd);
    return request.fd;
}

int main(int argc, char **argv)
{
    struct gpio_v2_line_values low = {.bits = 0, .mask = 1};
    int fd, struck;

    if (argc != 5)
        return 2;
    fd = raise_line(argv[1], (unsigned)strtoul(argv[2], NULL, 10));
    if (fd < 0) {
        perror(argv[1]);
        return 1;
    }
    struck = kill((pid_t)strtol(argv[4], NULL, 10), (int)strtol(argv[3], NULL, 10));
    if (struck < 0)
        perror("kill");
    return ioctl(fd, GPIO_V2_LINE_SET_VALUES_IOCTL, &low) < 0 || struck < 0;
}
