// The command line of ilp-onboard.
#pragma once

#include "bsp/flight/packet_links.hpp"
#include "bsp/linux/image_source.hpp"
#include "cfg/mission.hpp"
#include "fsw/base/geometry.hpp"

namespace ilp {

struct Options {
  const ImageSourceKind* source_kind = nullptr;
  const char* source = nullptr;  ///< value of its option
  const char* camera = nullptr;
  const char* size = nullptr;
  const char* navigation = nullptr;      ///< file
  const char* navigation_udp = nullptr;  ///< address
  const char* map = nullptr;             ///< folder
  const char* store = nullptr;           ///< a database file, `memory`, or the address of a server
  const char* stages = nullptr;          ///< null: all
  const char* state = nullptr;           ///< of the nonvolatile memory, where the store is no file
  const char* outbox = nullptr;
  const char* acknowledgements = nullptr;
  const char* mission = nullptr;
  PacketLinkOptions links;
  const char* key = nullptr;
  const char* lock_lease = nullptr;
  const char* priority = nullptr;
  const char* watchdog = nullptr;
  const char* compute = nullptr;  ///< socket of a compute device's program
  const char* worker = nullptr;   ///< `thread` or `inline`; null: by the clock
  bool mission_epoch = false;
  bool virtual_time = false;
  bool fly_on = false;
  bool without_authentication = false;  ///< links may be open to other computers all the same
  bool trap_heap = false;
  bool memory_map = false;
  bool version = false;
  bool help = false;
};

/// Why a command line is refused.
struct CommandLineFault {
  const char* word = "";          ///< the option at fault
  const char* reason = "";        ///< goes on after the word
  const char* nearest = nullptr;  ///< the option whose spelling is nearest, where `word` is none
};

void print_usage();

/// Whether `store` is the address of a PostgreSQL server.
[[nodiscard]] bool is_server(const char* store);
/// Whether the process runs a part of the stages without the primary.
[[nodiscard]] bool joins_flight(const Options& options);

/// Returns false and sets `fault` if an option is unknown, lacks its value, contradicts another one, or is missing.
[[nodiscard]] bool parse(int argc, char** argv, Options& options, CommandLineFault& fault);
/// Parses 6, 10, 11 or 14 numbers, or 6, the word fisheye and 4: see `usage`.
[[nodiscard]] bool parse_camera(const char* text, CameraModel& camera);
/// Parses `WIDTHxHEIGHT`.
[[nodiscard]] bool parse_size(const char* text, std::int32_t& width, std::int32_t& height);
/// Says what an option needs instead of `text`; false.
bool refused(const char* needs, const char* text);
/// Reads the mission file, if one is given. False, with a message, if it cannot be taken.
[[nodiscard]] bool read_mission(const Options& options, MissionParameters& mission);
/// Reads a real-time priority, 1 to 99, and the lease of the lock of the writers, 1 to 3600 s, if they are given.
/// False, with a message, where one is no such number.
[[nodiscard]] bool read_priority(const Options& options, int& priority);
[[nodiscard]] bool read_lock_lease(const Options& options, int& seconds);

}  // namespace ilp
