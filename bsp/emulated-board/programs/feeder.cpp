// Shows a recorded strip to vivid's camera, each picture at its time and byte for byte:
//   feeder CAPTURE OUTPUT INDEX LEAD_S
//
// INDEX has a line `time_ns file.pgm ...` per frame, times from 0. The first picture is shown at once; the strip begins
// LEAD_S later, and vivid repeats a picture until the next one comes.
// Descriptor 3 gets a byte as soon as the camera shows the first picture.

#include <fcntl.h>
#include <linux/v4l2-dv-timings.h>
#include <linux/videodev2.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>

#include "bsp/emulated-board/programs/processes.hpp"
#include "bsp/emulated-board/programs/readiness.hpp"
#include "bsp/emulated-board/programs/video_control.hpp"

namespace {

constexpr std::uint32_t buffer_count = 4;
constexpr std::size_t max_picture_bytes = 4U << 20U;
constexpr std::int64_t ns_per_s = 1'000'000'000;
constexpr std::int64_t longest_sleep_ns = ns_per_s / 2;
constexpr int camera_priority = 90;

bool fail(const char* what) {
  std::printf("feeder: %s: %s\n", what, std::strerror(errno));
  return false;
}

bool ask(int device, unsigned long what, void* argument, const char* name) {
  int answer = 0;
  do {
    answer = ioctl(device, what, argument);
  } while (answer < 0 && errno == EINTR);
  return answer == 0 || fail(name);
}

std::int64_t read_clock(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return time.tv_sec * ns_per_s + time.tv_nsec;
}

struct Picture {
  std::uint32_t width = 0, height = 0;
  std::uint8_t pixels[max_picture_bytes];
};

/// A binary PGM of 8 bits.
bool read_picture(const char* path, Picture& picture) {
  std::FILE* file = std::fopen(path, "re");
  if (file == nullptr) return fail(path);
  unsigned width = 0, height = 0, highest = 0;
  // NOLINTNEXTLINE(cert-err34-c): five digits fit, and what is no picture of ours is refused below
  const bool head = std::fscanf(file, "P5 %5u %5u %5u", &width, &height, &highest) == 3 && std::fgetc(file) != EOF;
  const std::size_t bytes = std::size_t{width} * height;
  const bool good = head && highest == 255 && bytes > 0 && bytes <= max_picture_bytes &&
                    std::fread(picture.pixels, 1, bytes, file) == bytes;
  std::fclose(file);
  picture.width = width;
  picture.height = height;
  errno = EINVAL;
  return good || fail(path);
}

/// CVT timings with reduced blanking, as slow as vivid takes them: its pixel clock has a lower limit.
v4l2_dv_timings timings_of(std::uint32_t width, std::uint32_t height) {
  constexpr std::uint32_t horizontal_blanking = 80, vsync = 8, back_porch = 6;
  constexpr double slowest_pixel_clock_hz = 14.2e6, slowest_hz = 15, shortest_blanking_s = 460e-6;
  v4l2_dv_timings timings{};
  timings.type = V4L2_DV_BT_656_1120;
  v4l2_bt_timings& bt = timings.bt;
  bt.width = width;
  bt.height = height;
  bt.polarities = V4L2_DV_HSYNC_POS_POL;
  bt.hfrontporch = 8;
  bt.hsync = 32;
  bt.hbackporch = 40;
  bt.vsync = vsync;
  bt.vbackporch = back_porch;
  bt.standards = V4L2_DV_BT_STD_CVT;
  bt.flags = V4L2_DV_FL_REDUCED_BLANKING;
  const double line = width + horizontal_blanking;
  const double rate_hz = std::max(slowest_hz, slowest_pixel_clock_hz / (line * (height + vsync + back_porch)));
  double lines_per_s = 0;
  bt.vfrontporch = 1;
  // The blanking counts in lines, whose length depends on it.
  for (int i = 0; i < 20; ++i) {
    lines_per_s = rate_hz * (height + vsync + back_porch + bt.vfrontporch);
    const int blanking = static_cast<int>(shortest_blanking_s * lines_per_s) + 1;
    bt.vfrontporch = static_cast<std::uint32_t>(std::max(1, blanking - static_cast<int>(vsync + back_porch)));
  }
  bt.pixelclock = static_cast<std::uint64_t>(lines_per_s * line) / 1000 * 1000;
  return timings;
}

bool set_control(int device, const char* name, std::int32_t value) {
  return board::set_control(device, name, value) || fail(name);
}

bool set_grey(int device, std::uint32_t type, std::uint32_t width, std::uint32_t height) {
  v4l2_format format{};
  format.type = type;
  format.fmt.pix.width = width;
  format.fmt.pix.height = height;
  format.fmt.pix.pixelformat = V4L2_PIX_FMT_GREY;
  format.fmt.pix.field = V4L2_FIELD_NONE;
  if (!ask(device, VIDIOC_S_FMT, &format, "format")) return false;
  const v4l2_pix_format& got = format.fmt.pix;
  errno = EINVAL;
  return (got.width == width && got.height == height && got.bytesperline == width) || fail("size");
}

/// The settings persist after the device is closed, so that the flight finds the loop when it opens the camera.
bool prepare_camera(const char* path, v4l2_dv_timings timings) {
  const int camera = open(path, O_RDWR | O_CLOEXEC);
  if (camera < 0) return fail(path);
  constexpr std::int32_t no_text_in_picture = 2, start_of_exposure = 1, on = 1;
  int hdmi = 1;
  const bool good = ask(camera, VIDIOC_S_INPUT, &hdmi, "input") &&
                    ask(camera, VIDIOC_S_DV_TIMINGS, &timings, "timings of the camera") &&
                    set_grey(camera, V4L2_BUF_TYPE_VIDEO_CAPTURE, timings.bt.width, timings.bt.height) &&
                    set_control(camera, "OSD Text Mode", no_text_in_picture) &&
                    set_control(camera, "Timestamp Source", start_of_exposure) && set_control(camera, "Loop Video", on);
  close(camera);
  return good;
}

class Screen {
 public:
  bool open_at(const char* path, v4l2_dv_timings timings) {
    device_ = open(path, O_RDWR | O_CLOEXEC);
    if (device_ < 0) return fail(path);
    int first = 0;
    return ask(device_, VIDIOC_S_OUTPUT, &first, "output") &&
           ask(device_, VIDIOC_S_DV_TIMINGS, &timings, "timings of the output") &&
           set_grey(device_, V4L2_BUF_TYPE_VIDEO_OUTPUT, timings.bt.width, timings.bt.height) && map_buffers();
  }

  bool show(const std::uint8_t* pixels, std::size_t bytes) {
    v4l2_buffer buffer = blank();
    // The first buffers are ours; later the oldest returns as soon as a newer one is on the screen.
    if (shown_ < buffers_) {
      buffer.index = shown_;
    } else if (!ask(device_, VIDIOC_DQBUF, &buffer, "taking a buffer back")) {
      return false;
    }
    std::memcpy(memory_[buffer.index], pixels, bytes);
    buffer.bytesused = static_cast<std::uint32_t>(bytes);
    buffer.field = V4L2_FIELD_NONE;
    if (!ask(device_, VIDIOC_QBUF, &buffer, "giving a buffer")) return false;
    int type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    return shown_++ > 0 || ask(device_, VIDIOC_STREAMON, &type, "streaming");
  }

 private:
  static v4l2_buffer blank() {
    v4l2_buffer buffer{};
    buffer.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    buffer.memory = V4L2_MEMORY_MMAP;
    return buffer;
  }

  bool map_buffers() {
    v4l2_requestbuffers request{};
    request.count = buffer_count;
    request.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    request.memory = V4L2_MEMORY_MMAP;
    if (!ask(device_, VIDIOC_REQBUFS, &request, "buffers")) return false;
    buffers_ = std::min(request.count, buffer_count);
    for (std::uint32_t i = 0; i < buffers_; ++i) {
      v4l2_buffer buffer = blank();
      buffer.index = i;
      if (!ask(device_, VIDIOC_QUERYBUF, &buffer, "buffer")) return false;
      memory_[i] = mmap(nullptr, buffer.length, PROT_READ | PROT_WRITE, MAP_SHARED, device_, buffer.m.offset);
      if (memory_[i] == MAP_FAILED) return fail("mapping a buffer");
    }
    return true;
  }

  int device_ = -1;
  std::uint32_t buffers_ = 0, shown_ = 0;
  void* memory_[buffer_count] = {};
};

struct Frame {
  std::int64_t time_ns = 0;
  char path[600] = {};
};

class Strip {
 public:
  explicit Strip(const char* index) : file_(std::fopen(index, "re")) {
    const char* slash = std::strrchr(index, '/');
    folder_length_ = slash != nullptr ? static_cast<int>(slash - index + 1) : 0;
    index_ = index;
  }
  [[nodiscard]] bool good() const { return file_ != nullptr; }

  bool next(Frame& frame) {
    char line[600], name[256];
    while (std::fgets(line, sizeof(line), file_) != nullptr) {
      // NOLINTNEXTLINE(cert-err34-c): eighteen digits fit
      if (std::sscanf(line, "%18ld %255s", &frame.time_ns, name) != 2) continue;
      std::snprintf(frame.path, sizeof(frame.path), "%.*s%s", name[0] == '/' ? 0 : folder_length_, index_, name);
      return true;
    }
    return false;
  }

 private:
  std::FILE* file_;
  const char* index_ = nullptr;
  int folder_length_ = 0;
};

Picture picture;
volatile std::sig_atomic_t stopped = 0;

void stop(int) {
  stopped = 1;
}

/// On a real board camera and screen are no programs, so these threads have priority over everything, the flight
/// software included.
void go_before_everything(pid_t thread) {
  sched_param parameters{};
  parameters.sched_priority = camera_priority;
  sched_setscheduler(thread, SCHED_FIFO, &parameters);
}

/// vivid starts its threads with each start of a stream.
void raise_camera_threads() {
  board::for_each_process([](int process, const char* name) {
    if (std::strncmp(name, "vivid-", 6) == 0) go_before_everything(process);
  });
}

/// Also returns when the program is stopped.
void sleep_until(std::int64_t monotonic_ns) {
  while (stopped == 0) {
    raise_camera_threads();
    const std::int64_t now = read_clock(CLOCK_MONOTONIC);
    if (now >= monotonic_ns) return;
    const std::int64_t until_ns = std::min(monotonic_ns, now + longest_sleep_ns);
    timespec until{};
    until.tv_sec = until_ns / ns_per_s;
    until.tv_nsec = until_ns % ns_per_s;
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
  }
}

void say_ready(std::int64_t begin_ns) {
  const std::int64_t utc_ns = begin_ns - read_clock(CLOCK_MONOTONIC) + read_clock(CLOCK_REALTIME);
  std::printf("feeder: %ux%u, strip begins at monotonic %lld ns, UTC %lld ns\n", picture.width, picture.height,
              static_cast<long long>(begin_ns), static_cast<long long>(utc_ns));
  board::say_ready();
}

int feed(const char* camera, const char* output, Strip& strip, std::int64_t lead_ns) {
  static Screen screen;
  Frame frame;
  if (!strip.next(frame) || !read_picture(frame.path, picture)) return 1;
  const v4l2_dv_timings timings = timings_of(picture.width, picture.height);
  // The output comes first, because a camera without a signal shows a pattern of its own.
  if (!screen.open_at(output, timings)) return 1;
  std::int64_t shown = 0, latest_ns = 0;
  const std::size_t bytes = std::size_t{picture.width} * picture.height;
  if (!screen.show(picture.pixels, bytes) || !prepare_camera(camera, timings)) return 1;
  const std::int64_t begin_ns = read_clock(CLOCK_MONOTONIC) + lead_ns;
  say_ready(begin_ns);
  while (stopped == 0 && strip.next(frame)) {
    if (!read_picture(frame.path, picture) || std::size_t{picture.width} * picture.height != bytes) return 1;
    sleep_until(begin_ns + frame.time_ns);
    if (stopped != 0) break;
    if (!screen.show(picture.pixels, bytes)) return 1;
    latest_ns = std::max(latest_ns, read_clock(CLOCK_MONOTONIC) - begin_ns - frame.time_ns);
    ++shown;
  }
  std::printf("feeder: %lld pictures shown, at most %lld us late\n", static_cast<long long>(shown) + 1,
              static_cast<long long>(latest_ns / 1000));
  // The camera keeps its picture as long as the output streams.
  while (stopped == 0) sleep_until(read_clock(CLOCK_MONOTONIC) + longest_sleep_ns);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 5) {
    std::printf("usage: feeder CAPTURE OUTPUT INDEX LEAD_S\n");
    return 2;
  }
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  go_before_everything(0);
  struct sigaction action {};
  action.sa_handler = stop;
  sigaction(SIGTERM, &action, nullptr);
  Strip strip(argv[3]);
  if (!strip.good()) return fail(argv[3]) ? 0 : 1;
  return feed(argv[1], argv[2], strip, static_cast<std::int64_t>(std::strtod(argv[4], nullptr) * 1e9));
}
