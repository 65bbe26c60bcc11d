/* The least a client can do, in C: receive, check the CRC of an ODOMETRY, send motor commands with its stamp.
   echo PORT PRIORITY CRC_EXTRA_OF_ODOMETRY CRC_EXTRA_OF_SET_ACTUATOR_CONTROL_TARGET */
#include <netinet/in.h>
#include <sched.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>

static uint16_t mcrf4xx(uint16_t crc, const uint8_t *data, size_t size) {
    while (size--) {
        uint8_t t = *data++ ^ (uint8_t)crc;
        t ^= t << 4;
        crc = crc >> 8 ^ t << 8 ^ t << 3 ^ t >> 4;
    }
    return crc;
}

int main(int count, char **words) {
    if (count != 5) return 2;
    struct sockaddr_in here = {.sin_family = AF_INET, .sin_port = htons(atoi(words[1]))}, peer;
    struct sched_param how = {.sched_priority = atoi(words[2])};
    uint8_t odometry = atoi(words[3]), target = atoi(words[4]), in[512];
    uint8_t out[55] = {0xFD, 43, 0, 0, 0, 1, 191, 139, 0, 0, [51] = 1, [52] = 1};
    int link = socket(AF_INET, SOCK_DGRAM, 0);
    here.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (how.sched_priority) sched_setscheduler(0, SCHED_FIFO, &how);
    if (bind(link, (struct sockaddr *)&here, sizeof here)) return 1;
    for (;;) {
        socklen_t size = sizeof peer;
        ssize_t n = recvfrom(link, in, sizeof in, 0, (struct sockaddr *)&peer, &size);
        if (n < 20 || in[7] != 0x4B || in[8] != 1 || in[9] != 0) continue;
        uint16_t crc = mcrf4xx(mcrf4xx(0xFFFF, in + 1, n - 3), &odometry, 1);
        if (in[n - 2] != (crc & 0xFF) || in[n - 1] != crc >> 8) continue;
        memcpy(out + 10, in + 10, 8);
        out[4]++;
        crc = mcrf4xx(mcrf4xx(0xFFFF, out + 1, 52), &target, 1);
        out[53] = crc & 0xFF, out[54] = crc >> 8;
        sendto(link, out, sizeof out, 0, (struct sockaddr *)&peer, size);
    }
}
