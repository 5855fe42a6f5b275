/* SPDX-License-Identifier: Apache-2.0 OR GPL-2.0-or-later */
/* rig_cable_iso.h: what dummy_hcd leaves out, for rig-cable (modules.sh puts it there): packets that are due in each frame. */

static void isochronous_packet(struct dummy *dum, struct urb *urb, struct dummy_ep *ep,
                               struct usb_iso_packet_descriptor *packet)
{
    struct dummy_request *req = list_first_entry_or_null(&ep->queue, struct dummy_request, queue);
    void *host = urb->transfer_buffer + packet->offset;

    packet->status = 0;
    packet->actual_length = 0;
    if (!req) /* the gadget has nothing to say in this one */
        return;
    packet->actual_length = min(packet->length, req->req.length);
    if (usb_urb_dir_in(urb))
        memcpy(host, req->req.buf, packet->actual_length);
    else
        memcpy(req->req.buf, host, packet->actual_length);
    req->req.actual = packet->actual_length;
    req->req.status = 0;
    list_del_init(&req->queue);
    spin_unlock(&dum->lock); /* the gadget may queue the next one */
    usb_gadget_giveback_request(&ep->ep, &req->req);
    spin_lock(&dum->lock);
}

/*
 * A frame's packets of an endpoint: each takes one of the gadget's requests, or is empty. The transfer ends with its last
 * packet, whatever was in them. A packet that was not yet due is what usb_submit_urb made it: -EXDEV. Returns the bytes.
 */
static int isochronous(struct dummy *dum, struct urb *urb, struct dummy_ep *ep, int *status)
{
    int due = ep->desc->bInterval >= 4 ? 1 : 8 >> (ep->desc->bInterval - 1);
    int i = 0, sent = 0;

    while (i < urb->number_of_packets && urb->iso_frame_desc[i].status != -EXDEV)
        i++;
    for (; i < urb->number_of_packets && due > 0; i++, due--) {
        isochronous_packet(dum, urb, ep, &urb->iso_frame_desc[i]);
        sent += urb->iso_frame_desc[i].actual_length;
    }
    urb->actual_length += sent;
    if (i == urb->number_of_packets)
        *status = 0;
    return sent;
}
