#include "bsp/linux/options.hpp"

#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "bsp/flight/mission_file.hpp"
#include "bsp/flight/nearest_word.hpp"
#include "bsp/flight/stage_set.hpp"
#include "bsp/linux/image_sources.hpp"
#include "bsp/linux/status_line.hpp"
#include "fsw/base/text.hpp"

namespace ilp {

namespace {

constexpr const char* usage_of_flight =
    "                   [--camera \"W H FX FY CX CY [LENS] [readout S]\" | --size WxH] --store STORE\n"
    "                   [--stages head,...]\n"
    "                   (--outbox DIR --acknowledgements DIR [--virtual-time] |\n"
    "                    [--link-udp ADDRESS:PORT [--link-udp-peer ADDRESS:PORT]] [--link-tcp ADDRESS:PORT]\n"
    "                    [--cfdp-udp ADDRESS:PORT [--cfdp-udp-peer ADDRESS:PORT]]\n"
    "                    [--key FILE | --without-authentication])\n"
    "                   [--navigation FILE.csv | --navigation-udp ADDRESS:PORT] [--map DIR] [--mission FILE.ini]\n"
    "                   [--mission-epoch] [--fly-on] [--priority N] [--watchdog DEVICE[:SECONDS]] [--compute SOCKET]\n"
    "                   [--worker thread|inline] [--lock-lease SECONDS] [--trap-heap]\n"
    "       ilp-onboard --stages STAGE,... --store STORE [--mission FILE.ini] [--priority N] [--lock-lease SECONDS]\n"
    "                   [--trap-heap]\n"
    "       ilp-onboard --memory-map | --version | --help\n";
constexpr const char* help_of_options =
    "  --camera        intrinsics in px, pixel centres at integers; LENS is K1 K2 P1 P2 [K3 [K4 K5 K6]] as OpenCV has\n"
    "                  them, or fisheye K1 K2 K3 K4; S: seconds from a rolling shutter's first row to its last,\n"
    "                  negative where the last row comes first; without --camera, the flight goes on\n"
    "                  with the camera on record, or begins with a nominal one if [calibration] camera_known = false\n"
    "  --size          size of the source's pictures in px, where no --camera says it and the source cannot; larger\n"
    "                  pictures than the profile's images are reduced, and the camera with them (docs/onboard.md)\n"
    "  --store         a database file (also --database), `memory`, or postgresql://... (docs/several-machines.md);\n"
    "                  a server needs --state FILE, a place for a few kilobytes beside it\n"
    "  --stages        the stages that this process runs, when several share the flight; `head` stands for all that "
    "need\n"
    "                  camera and links; without it all stages run here\n"
    "  --navigation    the vehicle's measurements, a CSV file; they are used then (docs/navigation.md)\n"
    "  --navigation-udp  packets of the vehicle's computer with its measurements, in real time (docs/navigation.md)\n"
    "  --map           folder with the tiles of an orbiter's map; keyframes are localised on it then;\n"
    "                  with --key it must be signed (docs/map-relative.md)\n"
    "  --link-udp, --link-tcp  telecommands and telemetry are space packets, and files go by CFDP (docs/links.md)\n"
    "  --cfdp-udp      CFDP PDUs are sent bare on a port of their own, not in space packets\n"
    "  --...-peer      the only station that is sent to; without it all stations are that have sent something\n"
    "  --key           file with the keys of telecommand authentication; [link] authentication turns it on\n"
    "  --without-authentication  whoever reaches the links may command the flight; without it, links that are not\n"
    "                  authenticated have to be at 127.0.0.1 (docs/links.md)\n"
    "  --mission-epoch mission time counts from [link] mission_epoch_s, not from the first start\n"
    "  --virtual-time  fly as fast as the machine allows, and stop when all images are processed\n"
    "  --fly-on        quarantine a database that is damaged or has another version; fly from memory without a disk\n"
    "  --priority      real-time priority, 1 to 99, with all memory locked\n"
    "  --watchdog      a watchdog device of the kernel, kicked once per minor frame; its timeout is 30 s by default\n"
    "  --compute       a compute device, by the socket of its program, such as ilp-compute-vulkan (docs/compute.md)\n"
    "  --worker        products are coded in a thread below the flight's priority, as by default in real time, or "
    "inline\n"
    "                  in steps, as by default in virtual time (docs/worker.md)\n"
    "  --lock-lease    a process of the flight that keeps the lock of the database file for longer is ended, so that\n"
    "                  it is started again: 10 s by default (docs/several-machines.md)\n"
    "  --trap-heap     abort on any allocation after start-up\n"
    "Example: ilp-onboard --index strip/index.txt --store flight.db --outbox outbox --acknowledgements acknowledged "
    "--virtual-time\n"
    "Exit status: 0 ended in order, 1 something could not be opened or recorded, or no frame was usable, 2 wrong call, "
    "3 the\n"
    "database or the memory is damaged\n";

/// Camera, links and clock belong to the primary.
bool joins_only(const Options& options) {
  const bool of_the_primary = options.source != nullptr || options.camera != nullptr || options.size != nullptr ||
                              options.outbox != nullptr || options.links.any() || options.navigation != nullptr ||
                              options.navigation_udp != nullptr || options.map != nullptr || options.virtual_time ||
                              options.mission_epoch || options.fly_on || options.key != nullptr ||
                              options.without_authentication || options.acknowledgements != nullptr ||
                              options.watchdog != nullptr || options.state != nullptr || options.compute != nullptr ||
                              options.worker != nullptr;
  return !of_the_primary && options.store != nullptr && std::strcmp(options.store, "memory") != 0;
}

}  // namespace

void print_usage() {
  std::fputs("The flight software of a balloon's imaging package: localises images, maps the ground, sends products\n",
             stdout);
  const char* before = "usage: ilp-onboard (";
  for (const ImageSourceKind& kind : ImageSources::kinds) {
    std::printf("%s%s %s", before, kind.option, kind.value);
    before = " | ";
  }
  std::fputs(")\n", stdout);
  std::fputs(usage_of_flight, stdout);
  for (const ImageSourceKind& kind : ImageSources::kinds) std::fputs(kind.help, stdout);
  std::fputs(help_of_options, stdout);
}

bool is_server(const char* store) {
  return std::strncmp(store, "postgresql://", 13) == 0 || std::strncmp(store, "postgres://", 11) == 0;
}

bool joins_flight(const Options& options) {
  if (options.stages == nullptr) return false;
  StageMask stages = 0;
  StageNames culprit;
  return parse_stages(options.stages, stages, culprit) && !is_primary(stages);
}

namespace {

struct Text {
  const char* name;
  const char** to;
};

struct Flag {
  const char* name;
  bool* to;
};

bool refuse(CommandLineFault& fault, const char* word, const char* reason) {
  fault = {word, reason, nullptr};
  return false;
}

/// Reads the words into `options`, each by itself.
bool read_words(int argc, char** argv, Options& options, CommandLineFault& fault) {
  const Text texts[] = {{"--camera", &options.camera},
                        {"--size", &options.size},
                        {"--navigation", &options.navigation},
                        {"--navigation-udp", &options.navigation_udp},
                        {"--map", &options.map},
                        {"--database", &options.store},
                        {"--store", &options.store},
                        {"--stages", &options.stages},
                        {"--state", &options.state},
                        {"--outbox", &options.outbox},
                        {"--acknowledgements", &options.acknowledgements},
                        {"--mission", &options.mission},
                        {"--link-udp", &options.links.udp},
                        {"--link-udp-peer", &options.links.udp_peer},
                        {"--link-tcp", &options.links.tcp},
                        {"--key", &options.key},
                        {"--lock-lease", &options.lock_lease},
                        {"--priority", &options.priority},
                        {"--watchdog", &options.watchdog},
                        {"--compute", &options.compute},
                        {"--worker", &options.worker},
                        {"--cfdp-udp", &options.links.cfdp},
                        {"--cfdp-udp-peer", &options.links.cfdp_peer}};
  const Flag flags[] = {{"--virtual-time", &options.virtual_time},
                        {"--mission-epoch", &options.mission_epoch},
                        {"--fly-on", &options.fly_on},
                        {"--without-authentication", &options.without_authentication},
                        {"--trap-heap", &options.trap_heap},
                        {"--memory-map", &options.memory_map},
                        {"--version", &options.version},
                        {"--help", &options.help}};
  for (int i = 1; i < argc; ++i) {
    bool known = false;
    for (const Flag& flag : flags) {
      if (std::strcmp(argv[i], flag.name) == 0) known = *flag.to = true;
    }
    for (const Text& text : texts) {
      if (known || std::strcmp(argv[i], text.name) != 0) continue;
      if (i + 1 == argc) return refuse(fault, argv[i], "needs a value");
      *text.to = argv[++i];
      known = true;
    }
    for (const ImageSourceKind& kind : ImageSources::kinds) {
      if (known || std::strcmp(argv[i], kind.option) != 0) continue;
      if (i + 1 == argc) return refuse(fault, argv[i], "needs a value");
      if (options.source_kind != nullptr && options.source_kind != &kind) {
        return refuse(fault, argv[i], "does not go with another source of images");
      }
      options.source_kind = &kind;
      options.source = argv[++i];
      known = true;
    }
    if (known) continue;
    NearestWord nearest(argv[i]);
    for (const ImageSourceKind& kind : ImageSources::kinds) nearest.offer(kind.option);
    for (const Flag& flag : flags) nearest.offer(flag.name);
    for (const Text& text : texts) nearest.offer(text.name);
    fault = {argv[i], "is no option", nearest.found()};
    return false;
  }
  return true;
}

bool check_links(const Options& options, CommandLineFault& fault) {
  // A link to others needs real time.
  if (options.links.any()) {
    return !options.virtual_time || refuse(fault, "--virtual-time", "does not go with a link to others");
  }
  if (options.outbox == nullptr) return refuse(fault, "--outbox", "is missing, and no link is stated");
  return options.acknowledgements != nullptr || refuse(fault, "--acknowledgements", "is missing");
}

/// There is one source of images, and a camera runs in real time.
bool check_images(const Options& options, CommandLineFault& fault) {
  static FixedText<128> names;
  if (options.source == nullptr) {
    for (const ImageSourceKind& kind : ImageSources::kinds)
      names.add(&kind == ImageSources::kinds ? "" : ", ").add(kind.option);
    return refuse(fault, names.c_str(), "are the sources of images: one is needed");
  }
  if (options.source_kind->needs_real_time && options.virtual_time) {
    return refuse(fault, options.source_kind->option, "does not go with --virtual-time");
  }
  return options.camera == nullptr || options.size == nullptr || refuse(fault, "--size", "does not go with --camera");
}

}  // namespace

bool parse(int argc, char** argv, Options& options, CommandLineFault& fault) {
  if (!read_words(argc, argv, options, fault)) return false;
  if (options.memory_map || options.version || options.help) return true;
  if (joins_flight(options)) {
    return joins_only(options) || refuse(fault, "--stages",
                                         "without `head` takes only --store (not in memory), "
                                         "--mission, --priority, --lock-lease and --trap-heap");
  }
  if (options.store == nullptr) return refuse(fault, "--store", "is missing");
  if (is_server(options.store) && options.state == nullptr) {
    return refuse(fault, "--state", "is missing, which a server as --store needs");
  }
  if (!check_links(options, fault)) return false;
  if (options.navigation_udp != nullptr && options.virtual_time) {
    return refuse(fault, "--virtual-time", "does not go with --navigation-udp");
  }
  if (options.navigation_udp != nullptr && options.navigation != nullptr) {
    return refuse(fault, "--navigation", "does not go with --navigation-udp");
  }
  const bool worker_known = options.worker == nullptr || std::strcmp(options.worker, "thread") == 0 ||
                            std::strcmp(options.worker, "inline") == 0;
  if (!worker_known) return refuse(fault, "--worker", "is thread or inline");
  return check_images(options, fault);
}

bool parse_camera(const char* text, CameraModel& camera) {
  constexpr int before_lens = 6, most = 14;
  double numbers[most] = {};
  int count = 0;
  Lens lens = Lens::brown;
  for (char* end = nullptr; count < most; ++count, text = end) {
    if (count == before_lens) {
      const char* const word = text + std::strspn(text, " ");
      const std::size_t length = std::strlen(name_of(Lens::fisheye));
      if (std::strncmp(word, name_of(Lens::fisheye), length) == 0) {
        lens = Lens::fisheye;
        text = word + length;
      }
    }
    numbers[count] = std::strtod(text, &end);
    if (end == text) break;
  }
  const bool known = lens == Lens::fisheye ? count == 10 : count == 6 || count == 10 || count == 11 || count == most;
  text += std::strspn(text, " \n");
  double readout_s = 0;
  constexpr const char* word = "readout";
  if (std::strncmp(text, word, std::strlen(word)) == 0) {
    char* end = nullptr;
    text += std::strlen(word);
    readout_s = std::strtod(text, &end);
    if (end == text) return false;
    text = end + std::strspn(end, " \n");
  }
  if (!known || *text != 0) return false;
  const double* const k = numbers + before_lens;
  camera = {static_cast<std::int32_t>(numbers[0]),
            static_cast<std::int32_t>(numbers[1]),
            numbers[2],
            numbers[3],
            numbers[4],
            numbers[5],
            k[0],
            k[1],
            k[2],
            k[3],
            k[4],
            k[5],
            k[6],
            k[7],
            lens};
  if (lens == Lens::fisheye) {
    camera.p1 = camera.p2 = 0;
    camera.k3 = k[2];
    camera.k4 = k[3];
  }
  camera.readout_s = readout_s;
  return true;
}

bool parse_size(const char* text, std::int32_t& width, std::int32_t& height) {
  char* end = nullptr;
  const long first = std::strtol(text, &end, 10);
  if (end == text || *end != 'x') return false;
  text = end + 1;
  const long second = std::strtol(text, &end, 10);
  if (end == text || *end != 0 || first < 1 || second < 1 || first > INT32_MAX || second > INT32_MAX) return false;
  width = static_cast<std::int32_t>(first);
  height = static_cast<std::int32_t>(second);
  return true;
}

bool refused(const char* needs, const char* text) {
  std::fprintf(stderr, "ilp-onboard: %s, not %s\n", needs, text);
  return false;
}

namespace {

bool read_number(const char* text, long most, const char* needs, int& number) {
  if (text == nullptr) return true;
  char* end = nullptr;
  const long value = std::strtol(text, &end, 10);
  if (end == text || *end != 0 || value < 1 || value > most) return refused(needs, text);
  number = static_cast<int>(value);
  return true;
}

}  // namespace

bool read_mission(const Options& options, MissionParameters& mission) {
  if (options.mission == nullptr) return true;
  MissionEntry error;
  const Status status = read_mission_file(options.mission, mission, error);
  if (status.ok()) return true;
  const auto fault = fault_of_mission(status, error);
  if (fault.size() == 0)
    print_status(options.mission, status);
  else
    std::fprintf(stderr, "ilp-onboard: mission file %s: %s\n", options.mission, fault.c_str());
  return false;
}

bool read_priority(const Options& options, int& priority) {
  return read_number(options.priority, 99, "--priority needs a number from 1 to 99", priority);
}

bool read_lock_lease(const Options& options, int& seconds) {
  return read_number(options.lock_lease, 3600, "--lock-lease needs a number of seconds from 1 to 3600", seconds);
}

}  // namespace ilp
