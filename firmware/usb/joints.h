/* SPDX-License-Identifier: Apache-2.0 */
/* joints.h: sockets joined to streams, one for each id. */
#ifndef USB_JOINTS_H
#define USB_JOINTS_H

#include <poll.h>

#include "ttf/usb/mux.h"

enum usb_joint_state {
    USB_JOINT_NONE = 0, /* the stream is not open */
    USB_JOINT_CALLING,  /* a connection is to be made, and the server has no room for it yet */
    USB_JOINT_JOINED,
    USB_JOINT_LEFT /* the socket is closed; the stream is ending */
};

struct usb_joint {
    enum usb_joint_state state;
    int fd;
    uint32_t life;     /* of the stream that it is for */
    bool read_ended;   /* nothing more comes from the socket */
    bool write_ended;  /* it was told that nothing more comes */
    bool write_broken; /* it takes no more */
    bool write_waits;  /* it was full */
    int64_t call_until_ns;
};

struct usb_joints {
    struct ttf_mux *mux;
    const char *server; /* of a box */
    struct usb_joint joint[TTF_MUX_STREAMS];
    uint8_t buffer[65536];
};

void usb_joints_init(struct usb_joints *joints, struct ttf_mux *mux, const char *server);

/* After each call of the mux that takes or gives: closes what is over, connects what was opened, moves what came. */
void usb_joints_follow(struct usb_joints *joints, int64_t now_ns);

/* Of a host: joins a connection to a new stream; it is closed if there is none to be had. */
void usb_joints_add(struct usb_joints *joints, int fd);

/* What to wait for; which[i] is the id of ret[i]. How many, at most TTF_MUX_STREAMS. */
unsigned usb_joints_fds(const struct usb_joints *joints, struct pollfd *ret, uint8_t *which);

/* What poll said of one. -ENOMEM. */
int usb_joints_ready(struct usb_joints *joints, unsigned id, short events);

/* Is any waiting for the server to have room? */
bool usb_joints_are_calling(const struct usb_joints *joints);

void usb_joints_close(struct usb_joints *joints);

#endif
