/* SPDX-License-Identifier: Apache-2.0 */
/* board_usb.c: what excludes what on a machine's USB ports and its power input, by what its board says of them. */
#include <errno.h>
#include <string.h>

#include "board_file.h"

int board_read_usb_devices(const struct cfg_field *field, struct yaml_node *node, void *at,
                           struct ttf_err *err)
{
    struct ttf_board_machine *m = &((struct ttf_board *)at)->machine;

    m->n_usb_devices = 0;
    if (node->kind != YAML_LIST)
        return cfg_error(node, err, field->meant, "a list is meant");
    for (struct yaml_node *c = node->child; c; c = c->next) {
        const char *text = cfg_scalar(c, field->meant, err);

        c->used = true;
        if (!text)
            return -EINVAL;
        if (m->n_usb_devices == TTF_USB_DEVICES_MAX)
            return cfg_error(c, err, field->meant, "more than %u", TTF_USB_DEVICES_MAX);
        if (!*text || strlen(text) >= sizeof m->usb_devices[0])
            return cfg_error(c, err, field->meant, "a text of 1 to 63 letters is meant");
        memcpy(m->usb_devices[m->n_usb_devices++], text, strlen(text) + 1);
    }
    return 0;
}

static bool is_v4l2(const struct ttf_board_camera *camera)
{
    return strcmp(camera->backend->name, "v4l2") == 0;
}

/* A camera of the board, a chip that one of its wires is at, or one of the two that have no name there. */
static bool is_of_the_board(const struct ttf_board *board, const char *name)
{
    if (strcmp(name, "disk") == 0 || strcmp(name, "network") == 0)
        return true;
    for (unsigned i = 0; i < board->n_cameras; i++)
        if (is_v4l2(&board->cameras[i]) && strcmp(board->cameras[i].name, name) == 0)
            return true;
    for (unsigned i = 0; i < board->guardian.n_wires; i++)
        if (strcmp(board->guardian.wires[i].chip, name) == 0)
            return true;
    for (unsigned i = 0; i < board->panel.n_wires; i++)
        if (strcmp(board->panel.wires[i].chip, name) == 0)
            return true;
    return false;
}

/* The one port that is a PC's device, or nothing, has room for nothing of the box. */
static int check_single(const struct ttf_board *board, struct yaml_node *root, struct ttf_err *err)
{
    static const char HINT[] = "write usb_role: host, and pull datasets by the network";
    const char *role = board->machine.usb_role == TTF_USB_DEVICE ? "is a device" : "is not used";
    struct yaml_node *list = yaml_child(yaml_child(root, "machine"), "usb_devices");
    struct yaml_node *cameras = yaml_child(root, "cameras");

    for (unsigned i = 0; i < board->n_cameras; i++) {
        const struct ttf_board_camera *camera = &board->cameras[i];

        if (!is_v4l2(camera))
            continue;
        if (strncmp(camera->v4l2.bus, "usb", 3) == 0)
            return cfg_error(yaml_child(cameras, camera->name), err, HINT,
                             "a USB camera, but the machine's one USB port %s", role);
        if (camera->v4l2.bus[0] == '\0')
            return cfg_error(yaml_child(cameras, camera->name), err,
                             "write its bus, as v4l2-ctl --list-devices has it: platform:...; a "
                             "USB camera needs usb_role: host",
                             "this may be a USB camera, but the machine's one USB port %s", role);
    }
    if (board->machine.n_usb_devices > 0)
        return cfg_error(list->child, err, HINT, "'%s', but the machine's one USB port %s",
                         board->machine.usb_devices[0], role);
    return 0;
}

/* Two supplies never meet, and a port does not feed what feeds it. */
static int check_power(const struct ttf_board_machine *m, struct yaml_node *machine,
                       struct ttf_err *err)
{
    bool by_usb = m->power == TTF_POWER_USB;

    if (by_usb && !m->usb_powers)
        return cfg_error(yaml_child(machine, "power"), err, "of such a port: usb_powers: true",
                         "its USB port is no power input");
    if (m->power == TTF_POWER_HEADER && m->header == TTF_HEADER_NONE)
        return cfg_error(yaml_child(machine, "power"), err, "write header: raspberry-pi, or socket",
                         "it has no header to be fed by");
    if (m->usb_powers && m->usb_role != TTF_USB_NONE && (by_usb || m->power == TTF_POWER_UNSAID))
        return cfg_error(yaml_child(machine, "usb_role"), err,
                         "write power: header, poe or socket; to a PC by a cable whose VBUS wire "
                         "is cut",
                         "that port is the power input, so it cannot be a %s as well",
                         m->usb_role == TTF_USB_DEVICE ? "device" : "host");
    return 0;
}

int board_finish_usb(const struct ttf_board *board, struct yaml_node *root, struct ttf_err *err)
{
    const struct ttf_board_machine *m = &board->machine;
    struct yaml_node *machine = yaml_child(root, "machine");
    struct yaml_node *name = machine ? yaml_child(machine, "usb_devices") : NULL;
    int r;

    if (!machine)
        return 0;
    name = name ? name->child : NULL;
    for (unsigned i = 0; name && i < m->n_usb_devices; i++, name = name->next)
        if (!is_of_the_board(board, m->usb_devices[i]))
            return cfg_error(name, err, "a v4l2 camera's name, a wire's chip, disk or network",
                             "the board has no '%s'", m->usb_devices[i]);
    r = check_power(m, machine, err);
    if (r == 0 && m->usb_single && m->usb_role != TTF_USB_HOST)
        r = check_single(board, root, err);
    return r;
}
