/* The least that a program can do to read servos: write a request, poll, read the answer, over and over.
 *
 * floor PATH SECONDS SERVOS prints one JSON line, as client.py does.
 */
#define _DEFAULT_SOURCE
#include <fcntl.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

enum { REQUEST = 8, ANSWER = 12, TIMEOUT_MS = 10, MOST = 254, JUMP = 200 };

static double seconds_of(clockid_t clock) {
    struct timespec at;
    clock_gettime(clock, &at);
    return (double)at.tv_sec + (double)at.tv_nsec * 1e-9;
}

static int open_line(const char *path) {
    struct termios line;
    int fd = open(path, O_RDWR | O_NOCTTY | O_NONBLOCK);
    if (fd < 0 || tcgetattr(fd, &line) < 0) {
        perror(path);
        exit(1);
    }
    cfmakeraw(&line);
    line.c_cc[VMIN] = 1;
    line.c_cc[VTIME] = 0;
    cfsetspeed(&line, B1000000);
    tcsetattr(fd, TCSANOW, &line);
    tcflush(fd, TCIOFLUSH);
    return fd;
}

static unsigned char sum_of(const unsigned char *from, int count) {
    unsigned char sum = 0;
    while (count--) sum += *from++;
    return (unsigned char)~sum;
}

/* Return the counter that an answer carries, -1 for none: what the register says less what is added to it. */
static int counter_of(const unsigned char *answer, int id) {
    int found[3];
    for (int word = 0; word < 3; word++) {
        int value = answer[5 + 2 * word] | answer[6 + 2 * word] << 8;
        found[word] = (value - 57 * id - 300 * word) & 1023;
    }
    return found[0] == found[1] && found[1] == found[2] ? found[0] : -1;
}

static int receive(int fd, unsigned char *answer) {
    int have = 0;
    struct pollfd wanted = {.fd = fd, .events = POLLIN};
    while (have < ANSWER) {
        if (poll(&wanted, 1, TIMEOUT_MS) <= 0) return 0;
        ssize_t got = read(fd, answer + have, (size_t)(ANSWER - have));
        if (got <= 0) return 0;
        have += (int)got;
    }
    return 1;
}

int main(int argc, char **argv) {
    if (argc != 4) {
        fprintf(stderr, "usage: floor PATH SECONDS SERVOS\n");
        return 2;
    }
    int fd = open_line(argv[1]), servos = atoi(argv[3]), last[MOST];
    long states = 0, lost = 0, wrong = 0, stale = 0;
    memset(last, -1, sizeof last);
    double begun = seconds_of(CLOCK_MONOTONIC), cpu = seconds_of(CLOCK_PROCESS_CPUTIME_ID);
    double until = begun + atof(argv[2]), now = begun;
    for (int turn = 0; now < until; turn++, now = seconds_of(CLOCK_MONOTONIC)) {
        int id = 1 + turn % servos;
        unsigned char request[REQUEST] = {0xFF, 0xFF, (unsigned char)id, 4, 2, 36, 6, 0}, answer[ANSWER];
        request[7] = sum_of(request + 2, 5);
        if (write(fd, request, REQUEST) != REQUEST || !receive(fd, answer) ||
            sum_of(answer + 2, ANSWER - 3) != answer[ANSWER - 1] || answer[2] != id) {
            lost++;
            tcflush(fd, TCIFLUSH);
            continue;
        }
        int counter = counter_of(answer, id), ahead = (counter - last[id]) & 1023;
        states++;
        if (counter < 0) wrong++;
        else if (last[id] >= 0 && (ahead == 0 || ahead > JUMP)) stale++;
        last[id] = counter;
    }
    now = seconds_of(CLOCK_MONOTONIC);
    cpu = seconds_of(CLOCK_PROCESS_CPUTIME_ID) - cpu;
    printf("{\"states\": %ld, \"lost\": %ld, \"wrong\": %ld, \"stale\": %ld, \"cpu_s\": %.6f, \"wall_s\": %.6f}\n", states,
           lost, wrong, stale, cpu, now - begun);
    return 0;
}
