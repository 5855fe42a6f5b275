/* SPDX-License-Identifier: Apache-2.0 */
/* board_services.c: `units:` and `gadget:` of a board: which services it runs, and what it is on the bus. */
#include <errno.h>
#include <string.h>

#include "board_file.h"

static const struct cfg_name UNITS[] = {{"ttfbox-lampd", TTF_UNIT_LAMPD},
                                        {"ttfboxd", TTF_UNIT_DAEMON},
                                        {"ttfbox-preview", TTF_UNIT_PREVIEW},
                                        {"ttfbox-alertd", TTF_UNIT_ALERTS},
                                        {"ttfbox-gadget", TTF_UNIT_GADGET},
                                        {"ttfbox-usbd", TTF_UNIT_CABLE},
                                        {NULL, 0}};
static const struct cfg_name FUNCTIONS[] = {
    {"streams", TTF_GADGET_STREAMS}, {"network", TTF_GADGET_NETWORK}, {NULL, 0}};

/* The i-th of those that are set, in the tables' order; NULL: there are no more. */
static const char *name_of(const struct cfg_name *names, unsigned set, unsigned i)
{
    for (; names->name; names++)
        if (set & (unsigned)names->value && i-- == 0)
            return names->name;
    return NULL;
}

const char *ttf_board_unit(const struct ttf_board *board, unsigned i)
{
    return name_of(UNITS, board->units, i);
}

const char *ttf_board_function(const struct ttf_board *board, unsigned i)
{
    return name_of(FUNCTIONS, board->gadget, i);
}

/* A list of names, each at most once, into a set of bits. */
static int read_set(const struct cfg_name *names, const char *meant, struct yaml_node *node,
                    unsigned *ret, struct ttf_err *err)
{
    unsigned set = 0;

    if (node->kind != YAML_LIST || !node->child)
        return cfg_error(node, err, meant, "a list is meant");
    for (struct yaml_node *c = node->child; c; c = c->next) {
        const char *text = cfg_scalar(c, meant, err);
        const struct cfg_name *n = names;

        c->used = true;
        if (!text)
            return -EINVAL;
        while (n->name && strcmp(n->name, text) != 0)
            n++;
        if (!n->name)
            return cfg_error(c, err, meant, "there is no '%.40s'", text);
        if (set & (unsigned)n->value)
            return cfg_error(c, err, meant, "'%s' is there twice", text);
        set |= (unsigned)n->value;
    }
    *ret = set;
    return 0;
}

int board_read_units(const struct cfg_field *field, struct yaml_node *node, void *at,
                     struct ttf_err *err)
{
    return read_set(UNITS, field->meant, node, &((struct ttf_board *)at)->units, err);
}

static int read_functions(const struct cfg_field *field, struct yaml_node *node, void *at,
                          struct ttf_err *err)
{
    return read_set(FUNCTIONS, field->meant, node, &((struct ttf_board *)at)->gadget, err);
}

static const struct cfg_field GADGET[] = {
    {"functions", read_functions, 0, 0, 0, "a list of streams and network", 0, true}, {0}};

int board_read_gadget(const struct cfg_field *field, struct yaml_node *node, void *at,
                      struct ttf_err *err)
{
    (void)field;
    return cfg_map(GADGET, node, at, err);
}

static int check_gadget(const struct ttf_board *board, struct yaml_node *node, struct ttf_err *err)
{
    if (board->machine.usb_role != TTF_USB_DEVICE)
        return cfg_error(node, err,
                         "write machine: {usb_role: device}, or no gadget and no ttfbox-gadget and "
                         "ttfbox-usbd in units",
                         "a gadget, but no USB port of the machine is a device");
    if (!(board->gadget & TTF_GADGET_STREAMS))
        return cfg_error(node, err, "write functions: [streams] or [streams, network]",
                         "without streams nobody binds it: it is ttfbox-usbd that is waited for");
    return 0;
}

static bool by_set(const struct yaml_node *root, const struct yaml_node *node)
{
    return node && node->file != root->file;
}

/*
 * --set and a configuration's set: change what a key says and cannot take one away: where such a change makes the port no
 * device, what the board's own file says of a PC's device goes with it. What was set beside it has to fit.
 */
static bool is_device_no_more(const struct ttf_board *board, const struct yaml_node *root)
{
    const struct yaml_node *machine = yaml_child(root, "machine"),
                           *gadget = yaml_child(root, "gadget");
    const struct yaml_node *role = machine ? yaml_child(machine, "usb_role") : NULL;

    return board->machine.usb_role != TTF_USB_DEVICE && by_set(root, role ? role : machine) &&
           gadget && !by_set(root, yaml_child(gadget, "functions"));
}

int board_finish_services(struct ttf_board *board, struct yaml_node *root, struct ttf_err *err)
{
    const struct ttf_backend_entry *lamps = board->device[TTF_DEVICE_LAMPS];
    const unsigned cable = TTF_UNIT_GADGET | TTF_UNIT_CABLE;
    struct yaml_node *units = yaml_child(root, "units");
    struct yaml_node *gadget = yaml_child(root, "gadget");
    int r;

    if (is_device_no_more(board, root)) {
        gadget = NULL;
        board->gadget = 0;
        board->units &= by_set(root, units) ? ~0u : ~cable;
    }
    r = gadget ? check_gadget(board, gadget, err) : 0;

    if (r < 0 || !units)
        return r;
    if (!(board->units & TTF_UNIT_DAEMON))
        return cfg_error(units, err, "add ttfboxd", "without ttfboxd nothing runs a plan");
    if (lamps && strcmp(lamps->name, "sim") != 0 && !(board->units & TTF_UNIT_LAMPD))
        return cfg_error(units, err, "add ttfbox-lampd",
                         "lamps with wires and no guardian: nobody would turn them on, or off");
    if ((board->units & cable) != 0 && (board->units & cable) != cable)
        return cfg_error(units, err, "both or none",
                         "of ttfbox-gadget and ttfbox-usbd one is nothing without the other");
    if ((board->units & cable) != 0 && !gadget)
        return cfg_error(units, err, "write gadget: {functions: [streams, network]}",
                         "a cable's services, and no gadget");
    if (gadget && (board->units & cable) == 0)
        return cfg_error(units, err, "add ttfbox-gadget and ttfbox-usbd",
                         "a gadget that no service composes");
    return 0;
}
