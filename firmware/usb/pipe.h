/* SPDX-License-Identifier: Apache-2.0 */
/* pipe.h: what the ends of a simulated cable and the cable say to each other: messages of a SEQPACKET socket. */
#ifndef USB_PIPE_H
#define USB_PIPE_H

#include <stdint.h>

#define USB_PIPE_PACKET 512u /* a piece that is a multiple of it is not a transfer's last */

enum usb_pipe_kind {
    USB_PIPE_HOST = 'H', /* host -> cable: I am the host */
    USB_PIPE_BOX = 'B',  /* box -> cable: I am the box; I am a new process and have nothing */
    USB_PIPE_UP =
        'U', /* cable -> both: with two descriptors, of the end that reads and of the end that writes */
    USB_PIPE_DOWN = 'D',    /* cable -> box */
    USB_PIPE_NOBODY = 'N',  /* cable -> host: no box is plugged in */
    USB_PIPE_BUSY = 'Y',    /* cable -> host: another has it */
    USB_PIPE_SUSPEND = 'S', /* cable -> box */
    USB_PIPE_RESUME = 'R',
    USB_PIPE_RESET = 'X',  /* host -> cable -> box */
    USB_PIPE_ANSWER = 'A', /* box -> cable -> host */
    USB_PIPE_FAILED = 'F'  /* cable -> host: the box did not answer */
};

struct usb_pipe_message {
    uint64_t kind;
    uint64_t nonce;
};

#endif
