/* SPDX-License-Identifier: Apache-2.0 */
/*
 * serial.c: what a machine is known by. firmware/gadget/ttfbox-gadget follows the same rule, so that a box has one serial, on the bus
 * and in its answers: a test holds the two together.
 */
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "devices.h"
#include "ttf/dataset/hash.h"

#define DIGITS_MAX 32 /* on the bus */
#define MADE       12 /* of one that is made */

/* Of a file's first line the letters and digits; what stands for none (nothing, all 0) is none. */
static bool read_digits(const char *folder, const char *name, char ret[64])
{
    char path[512], text[256];
    size_t n = 0, got;
    FILE *file;

    (void)snprintf(path, sizeof path, "%s/%s", folder, name);
    file = fopen(path, "re");
    if (!file)
        return false;
    got = fread(text, 1, sizeof text, file);
    (void)fclose(file);
    for (size_t i = 0; i < got && text[i] != '\n' && n < DIGITS_MAX; i++) {
        const char c = text[i];

        if ((c >= '0' && c <= '9') || ((c | 0x20) >= 'a' && (c | 0x20) <= 'z'))
            ret[n++] = c;
    }
    ret[n] = '\0';
    return strspn(ret, "0") < n;
}

/* What this installation is known by, which is nobody's business, hashed. */
static bool make_from_machine_id(const char *etc, char ret[64])
{
    static const char PURPOSE[] = "ttfbox serial ";
    struct ttf_sha256 hash;
    char id[64], hex[65];

    if (!read_digits(etc, "machine-id", id))
        return false;
    ttf_sha256_init(&hash);
    ttf_sha256_add(&hash, PURPOSE, sizeof PURPOSE - 1);
    ttf_sha256_add(&hash, id, strlen(id));
    ttf_sha256_hex(&hash, hex);
    (void)snprintf(ret, 64, "%.*s", MADE, hex);
    return true;
}

void box_host_serial(const struct box_host *host, char ret[64])
{
    const char *etc = host->etc ? host->etc : "/etc";
    char firmware[256];

    (void)snprintf(firmware, sizeof firmware, "%.200s/firmware/devicetree/base",
                   host->sys ? host->sys : "/sys");
    if (read_digits(etc, "ttfbox/usb-serial", ret) || read_digits(firmware, "serial-number", ret) ||
        make_from_machine_id(etc, ret))
        return;
    if (gethostname(ret, 63) < 0)
        *ret = '\0';
    ret[63] = '\0';
}
