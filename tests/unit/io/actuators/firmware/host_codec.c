/* Bytes on stdin → for each message accepted, the offset of its last byte (u32, little endian), its length (u16) and its frame, encoded anew. */
#include "usv_frame.h"

#include <stdio.h>

int main(void)
{
    static uint8_t chunk[65536];
    usv_receiver receiver;
    usv_message message;
    uint8_t frame[USV_MAX_FRAME];
    uint32_t offset = 0;
    usv_receiver_start(&receiver);
    for (size_t n = fread(chunk, 1, sizeof chunk, stdin); n > 0; n = fread(chunk, 1, sizeof chunk, stdin)) {
        for (size_t i = 0; i < n; i++, offset++) {
            if (!usv_receive(&receiver, chunk[i], &message)) {
                continue;
            }
            const size_t length = usv_encode(&message, frame);
            const uint8_t head[6] = {(uint8_t)offset, (uint8_t)(offset >> 8), (uint8_t)(offset >> 16), (uint8_t)(offset >> 24),
                                     (uint8_t)length, (uint8_t)(length >> 8)};
            fwrite(head, 1, sizeof head, stdout);
            fwrite(frame, 1, length, stdout);
        }
    }
    fprintf(stderr, "%lu %lu\n", (unsigned long)receiver.frames, (unsigned long)receiver.errors);
    return 0;
}
