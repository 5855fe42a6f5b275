/* SPDX-License-Identifier: Apache-2.0 */
/* usb.c: who holds the USB device controller, and whether that is what the board wants of its port. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "files.h"

#define OURS "ttfbox" /* what firmware/gadget calls its gadget */

/* A gadget made by configfs names the controller that it is bound to. */
static bool bound_gadget(const struct probe_machine *m, const char *controller, char ret[64])
{
    char **gadgets = probe_names(m, "sys/kernel/config/usb_gadget");
    char path[384], text[96];
    bool found = false;

    for (char **g = gadgets; g && *g && !found; g++) {
        (void)snprintf(path, sizeof path, "sys/kernel/config/usb_gadget/%.200s/UDC", *g);
        found = probe_line(m, path, text, sizeof text) && strcmp(text, controller) == 0;
        if (found)
            (void)snprintf(ret, 64, "%.63s", *g);
    }
    probe_names_free(gadgets);
    return found;
}

/* By configfs, or by the driver's own word, which is the gadget's name, too. */
static bool find_holder(const struct probe_machine *m, const char *controller, char ret[64])
{
    char path[384];

    (void)snprintf(path, sizeof path, "sys/class/udc/%.200s/function", controller);
    return bound_gadget(m, controller, ret) || (probe_line(m, path, ret, 64) && *ret);
}

static void no_controller(const struct probe_machine *m, struct probe_findings *findings)
{
    char model[96];
    bool pi = strncmp(probe_model(m, model), "Raspberry Pi", 12) == 0;

    probe_add(findings, PROBE_PROBLEM, "usb",
              pi ? "dtoverlay=dwc2,dr_mode=peripheral in config.txt switches it on; or let the "
                   "board say usb_role: none, and pull by the network"
                 : "load its driver; a machine without one lets the board say usb_role: none, and "
                   "is pulled from by the network",
              "no USB device controller, though the board says usb_role: device: no PC can pull "
              "datasets over a USB cable");
}

static void our_own(const struct probe_machine *m, const char *controller,
                    struct probe_findings *findings)
{
    char path[384], state[32];

    (void)snprintf(path, sizeof path, "sys/class/udc/%.200s/state", controller);
    (void)probe_line(m, path, state, sizeof state);
    probe_add(findings, PROBE_NOTE, "usb", NULL,
              "USB device controller %.60s is held by this box's own gadget, as it should be; %s",
              controller,
              strcmp(state, "configured") == 0 ? "a PC has set it up"
                                               : "no PC at its cable has set it up");
}

/* Of a port that is to be a PC's device. */
static void as_device(const struct probe_machine *m, char **controllers,
                      struct probe_findings *findings)
{
    char holder[64];
    bool ours = false;

    for (char **c = controllers; c && *c; c++)
        if (find_holder(m, *c, holder) && strcmp(holder, OURS) == 0) {
            ours = true;
            our_own(m, *c, findings);
        }
    for (char **c = controllers; c && *c && !ours; c++)
        if (find_holder(m, *c, holder))
            probe_add(findings, PROBE_PROBLEM, "usb",
                      "a controller has one gadget: unload that one for ttfbox-usbd to have it",
                      "USB device controller %.60s is held by gadget '%s'", *c, holder);
        else
            probe_add(findings, PROBE_NOTE, "usb",
                      "systemctl enable --now ttfbox-gadget ttfbox-usbd; journalctl -u "
                      "ttfbox-usbd says what is wrong with it",
                      "USB device controller %.60s has no gadget: a PC at its cable sees nothing",
                      *c);
}

/* What is plugged into a port that is a device is not seen. */
static void as_host(const struct probe_machine *m, bool single, char **controllers,
                    struct probe_findings *findings)
{
    char holder[64];

    for (char **c = controllers; c && *c; c++)
        if (find_holder(m, *c, holder))
            probe_add(
                findings, single ? PROBE_PROBLEM : PROBE_NOTE, "usb",
                "unload the gadget (ours: systemctl disable --now ttfbox-usbd ttfbox-gadget), "
                "and take dr_mode=peripheral out of config.txt",
                "the board says usb_role: host, but that port is a device: gadget '%s' holds "
                "%.60s, and what is plugged in there is not seen",
                holder, *c);
}

void probe_usb(const struct probe_machine *machine, const struct ttf_board *board,
               struct probe_findings *findings)
{
    char **controllers = probe_names(machine, "sys/class/udc");
    bool any = controllers && *controllers;

    if (board->machine.usb_role == TTF_USB_DEVICE && !any)
        no_controller(machine, findings);
    else if (board->machine.usb_role == TTF_USB_DEVICE)
        as_device(machine, controllers, findings);
    else if (board->machine.usb_role == TTF_USB_HOST)
        as_host(machine, board->machine.usb_single, controllers, findings);
    if (board->machine.usb_role == TTF_USB_DEVICE && board->machine.usb_powers && any)
        probe_add(
            findings, PROBE_NOTE, "usb",
            "power the machine by its header or PoE, and take a cable whose VBUS wire is cut: "
            "through a whole one the PC and the supply feed each other",
            "the USB port that a PC pulls by is the power input, too");
    probe_names_free(controllers);
}
