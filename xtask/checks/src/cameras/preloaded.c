/* A driver of Video4Linux inside the process that uses it (LD_PRELOAD), for what the kernel's virtual
 * cameras cannot do: motion JPEG, damaged frames, gaps at known places, rows with padding, odd codes.
 *
 * The devices are files named camera0 and camera1. Each gives the frames of a script, CAMERA0 or
 * CAMERA1, one after the other, each when its time has come, never more, never fewer: where no buffer is
 * queued a frame waits. A frame in a script: length, sequence (32 bits each), time after the start in
 * us (64 bits), bytes. FORMAT is the code on offer, SIZE its WxH, ROW_BYTES and FIELD what is said of
 * it, HZ the rate.
 *
 * With CONTROLS, a file to note in what is set, cameras have controls of exposure: the automatic is on
 * and may lower the rate; the time can be set while it is off, in steps of 0.8 ms. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <linux/videodev2.h>
#include <poll.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#define BUFFERS 8
/* Between the first start of a camera and the first frame: time to start the other. */
#define LEAD_US 400000

struct frame {
    uint32_t length, sequence;
    uint64_t time_us;
};

struct camera {
    int fd;
    /* Another one, open beside it for the controls. */
    int second_fd;
    FILE *script;
    struct frame next;
    int has_next, is_on;
    uint32_t count, bytes;
    char *memory;
    int queued[BUFFERS];
    struct v4l2_buffer filled[BUFFERS];
    int filled_count;
};

static struct camera cameras[2] = {{.fd = -1, .second_fd = -1}, {.fd = -1, .second_fd = -1}};

/* Of both cameras, whether they are open or not. */
enum { AUTO, TIME, DYNAMIC_RATE, CONTROLS };
static int values[2][CONTROLS] = {{V4L2_EXPOSURE_APERTURE_PRIORITY, 160, 1},
                                  {V4L2_EXPOSURE_APERTURE_PRIORITY, 240, 1}};
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static uint64_t start_us;

static uint64_t now_us(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return now.tv_sec * 1000000ull + now.tv_nsec / 1000;
}

static unsigned number(const char *name, unsigned otherwise) {
    const char *text = getenv(name);
    return text ? strtoul(text, 0, 0) : otherwise;
}

static struct camera *camera_of(int fd) {
    for (int i = 0; i < 2; i++)
        if (fd >= 0 && (cameras[i].fd == fd || cameras[i].second_fd == fd)) return &cameras[i];
    return 0;
}

static void read_next(struct camera *c) {
    c->has_next = fread(&c->next, sizeof c->next, 1, c->script) == 1;
}

/* Opens a camera; -2 for any other file. */
static int open_camera(const char *path) {
    const char *name = strrchr(path, '/');
    name = name ? name + 1 : path;
    if (strcmp(name, "camera0") && strcmp(name, "camera1")) return -2;
    struct camera *c = &cameras[name[6] - '0'];
    if (c->fd >= 0) {
        if (c->second_fd < 0) return c->second_fd = memfd_create(name, 0);
        errno = EBUSY;
        return -1;
    }
    memset(c, 0, sizeof *c);
    c->second_fd = -1;
    c->script = fopen(getenv(name[6] == '0' ? "CAMERA0" : "CAMERA1"), "rb");
    if (!c->script) abort();
    read_next(c);
    return c->fd = memfd_create(name, 0);
}

int open(const char *path, int flags, ...) {
    va_list list;
    va_start(list, flags);
    int mode = va_arg(list, int), fd = open_camera(path);
    va_end(list);
    int (*real)(const char *, int, ...) = dlsym(RTLD_NEXT, "open");
    return fd == -2 ? real(path, flags, mode) : fd;
}

int open64(const char *path, int flags, ...) {
    va_list list;
    va_start(list, flags);
    int mode = va_arg(list, int), fd = open_camera(path);
    va_end(list);
    int (*real)(const char *, int, ...) = dlsym(RTLD_NEXT, "open64");
    return fd == -2 ? real(path, flags, mode) : fd;
}

int close(int fd) {
    struct camera *c = camera_of(fd);
    if (c) *(fd == c->fd ? &c->fd : &c->second_fd) = -1;
    int (*real)(int) = dlsym(RTLD_NEXT, "close");
    return real(fd);
}

/* Puts frames whose time has come into queued buffers. */
static void fill(struct camera *c) {
    while (c->is_on && c->has_next && start_us + c->next.time_us <= now_us()) {
        unsigned i = 0;
        while (i < c->count && !c->queued[i]) i++;
        if (i == c->count) return;
        c->queued[i] = 0;
        if (fread(c->memory + i * c->bytes, 1, c->next.length, c->script) != c->next.length) abort();
        uint64_t time_us = start_us + c->next.time_us;
        c->filled[c->filled_count++] = (struct v4l2_buffer){
            .index = i,
            .bytesused = c->next.length,
            .sequence = c->next.sequence,
            .timestamp = {.tv_sec = time_us / 1000000, .tv_usec = time_us % 1000000},
            .flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_MAPPED,
        };
        read_next(c);
    }
}

static uint32_t code(void) {
    const char *text = getenv("FORMAT");
    return v4l2_fourcc(text[0], text[1], text[2], text[3]);
}

static struct v4l2_pix_format picture(void) {
    unsigned width = 0, height = 0;
    if (sscanf(getenv("SIZE"), "%ux%u", &width, &height) != 2) abort();
    return (struct v4l2_pix_format){
        .width = width,
        .height = height,
        .pixelformat = code(),
        .bytesperline = number("ROW_BYTES", 0),
        .sizeimage = 4 * width * height,
        .field = number("FIELD", V4L2_FIELD_NONE),
        .colorspace = V4L2_COLORSPACE_SRGB,
    };
}

static int refuse(int error) {
    errno = error;
    return -1;
}

static int control_of(uint32_t id) {
    switch (id) {
    case V4L2_CID_EXPOSURE_AUTO: return AUTO;
    case V4L2_CID_EXPOSURE_ABSOLUTE: return TIME;
    case V4L2_CID_EXPOSURE_AUTO_PRIORITY: return DYNAMIC_RATE;
    default: return -1;
    }
}

static int ask_control(int camera, unsigned request, void *answer) {
    if (!getenv("CONTROLS")) return refuse(ENOTTY);
    if (request == VIDIOC_QUERY_EXT_CTRL) {
        struct v4l2_query_ext_ctrl *asked = answer;
        int control = control_of(asked->id);
        if (control < 0) return refuse(EINVAL);
        asked->type = control == AUTO   ? V4L2_CTRL_TYPE_MENU
                      : control == TIME ? V4L2_CTRL_TYPE_INTEGER
                                        : V4L2_CTRL_TYPE_BOOLEAN;
        return 0;
    }
    struct v4l2_ext_control *asked = ((struct v4l2_ext_controls *)answer)->controls;
    int control = control_of(asked->id), *value = &values[camera][control];
    if (control < 0) return refuse(EINVAL);
    if (request == VIDIOC_S_EXT_CTRLS) {
        if (control == TIME && values[camera][AUTO] != V4L2_EXPOSURE_MANUAL) return refuse(EACCES);
        *value = control == TIME ? asked->value / 8 * 8 : asked->value;
        FILE *notes = fopen(getenv("CONTROLS"), "a");
        if (!notes) abort();
        static const char *names[] = {"auto", "time", "dynamic_rate"};
        fprintf(notes, "camera%d %s %d\n", camera, names[control], *value);
        fclose(notes);
    }
    asked->value = *value;
    return 0;
}

static int ask(struct camera *c, unsigned request, void *answer) {
    switch (request) {
    case VIDIOC_QUERY_EXT_CTRL:
    case VIDIOC_G_EXT_CTRLS:
    case VIDIOC_S_EXT_CTRLS:
        return ask_control(c - cameras, request, answer);
    case VIDIOC_QUERYCAP: {
        uint32_t can = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
        *(struct v4l2_capability *)answer = (struct v4l2_capability){
            .driver = "preloaded", .card = "Preloaded", .capabilities = can | V4L2_CAP_DEVICE_CAPS,
            .device_caps = can};
        return 0;
    }
    case VIDIOC_ENUM_FMT: {
        struct v4l2_fmtdesc *format = answer;
        if (format->index) return refuse(EINVAL);
        format->pixelformat = code();
        return 0;
    }
    case VIDIOC_ENUM_FRAMESIZES: {
        struct v4l2_frmsizeenum *size = answer;
        if (size->index) return refuse(EINVAL);
        size->type = V4L2_FRMSIZE_TYPE_DISCRETE;
        size->discrete.width = picture().width;
        size->discrete.height = picture().height;
        return 0;
    }
    case VIDIOC_G_FMT:
    case VIDIOC_S_FMT:
        ((struct v4l2_format *)answer)->fmt.pix = picture();
        return 0;
    case VIDIOC_G_PARM:
    case VIDIOC_S_PARM: {
        struct v4l2_captureparm *capture = &((struct v4l2_streamparm *)answer)->parm.capture;
        capture->timeperframe = (struct v4l2_fract){1, number("HZ", 30)};
        return 0;
    }
    case VIDIOC_REQBUFS: {
        struct v4l2_requestbuffers *asked = answer;
        if (asked->count > BUFFERS) asked->count = BUFFERS;
        c->count = asked->count;
        c->filled_count = 0;
        memset(c->queued, 0, sizeof c->queued);
        if (!c->count) return 0;
        c->bytes = (picture().sizeimage + 8191) / 4096 * 4096;
        if (ftruncate(c->fd, (off_t)c->bytes * c->count)) abort();
        c->memory = mmap(0, (size_t)c->bytes * c->count, PROT_WRITE, MAP_SHARED, c->fd, 0);
        return 0;
    }
    case VIDIOC_QUERYBUF: {
        struct v4l2_buffer *buffer = answer;
        buffer->length = c->bytes;
        buffer->m.offset = buffer->index * c->bytes;
        return 0;
    }
    case VIDIOC_QBUF:
        c->queued[((struct v4l2_buffer *)answer)->index] = 1;
        return 0;
    case VIDIOC_DQBUF:
        fill(c);
        if (!c->filled_count) return refuse(EAGAIN);
        *(struct v4l2_buffer *)answer = c->filled[0];
        memmove(c->filled, c->filled + 1, --c->filled_count * sizeof *c->filled);
        return 0;
    case VIDIOC_STREAMON:
        if (!start_us) start_us = now_us() + LEAD_US;
        c->is_on = 1;
        return 0;
    case VIDIOC_STREAMOFF:
        c->is_on = 0;
        return 0;
    default:
        return refuse(ENOTTY);
    }
}

/* The binding asks drivers through this. */
long syscall(long n, ...) {
    va_list list;
    va_start(list, n);
    long x[6];
    for (int i = 0; i < 6; i++) x[i] = va_arg(list, long);
    va_end(list);
    struct camera *c = n == SYS_ioctl ? camera_of(x[0]) : 0;
    if (c) {
        pthread_mutex_lock(&lock);
        int answer = ask(c, x[1], (void *)x[2]), error = errno;
        pthread_mutex_unlock(&lock);
        errno = error;
        return answer;
    }
    static long (*real)(long, ...);
    if (!real) real = dlsym(RTLD_NEXT, "syscall");
    return real(n, x[0], x[1], x[2], x[3], x[4], x[5]);
}

int poll(struct pollfd *asked, nfds_t count, int within_ms) {
    struct camera *c = count == 1 ? camera_of(asked[0].fd) : 0;
    if (!c) {
        static int (*real)(struct pollfd *, nfds_t, int);
        if (!real) real = dlsym(RTLD_NEXT, "poll");
        return real(asked, count, within_ms);
    }
    uint64_t end_us = now_us() + within_ms * 1000ull;
    for (;;) {
        pthread_mutex_lock(&lock);
        fill(c);
        int ready = c->filled_count > 0;
        pthread_mutex_unlock(&lock);
        asked[0].revents = ready ? POLLIN : 0;
        if (ready || now_us() >= end_us) return ready;
        usleep(500);
    }
}
