// Parses the command line of ilp-onboard.
#pragma once

#include "bsp/flight/packet_links.hpp"
#include "bsp/linux/image_source.hpp"
#include "cfg/mission.hpp"
#include "fsw/base/geometry.hpp"

namespace ilp {

/// Values of the options; print_usage() describes them. Null: the option was not given.
struct Options {
  const ImageSourceKind* source_kind = nullptr;
  const char* source = nullptr;  ///< value of the option of `source_kind`
  const char* camera = nullptr;
  const char* size = nullptr;
  const char* navigation = nullptr;      ///< file with the vehicle's measurements
  const char* navigation_udp = nullptr;  ///< address at which the vehicle's measurements arrive
  const char* map = nullptr;             ///< folder of an orbiter's map
  const char* store = nullptr;           ///< a database file, `memory`, or the address of a server
  const char* stages = nullptr;          ///< stages of this process; null: all
  const char* state = nullptr;           ///< path of the nonvolatile memory, if the store is a server
  const char* outbox = nullptr;
  const char* acknowledgements = nullptr;
  const char* mission = nullptr;
  PacketLinkOptions links;
  const char* key = nullptr;
  const char* lock_lease = nullptr;
  const char* priority = nullptr;
  const char* watchdog = nullptr;
  const char* compute = nullptr;  ///< socket of a compute device's program
  const char* worker = nullptr;   ///< `thread` or `inline`; null: thread in real time, inline in virtual time
  bool mission_epoch = false;
  bool virtual_time = false;
  bool fly_on = false;
  bool without_authentication = false;  ///< other computers may reach links without authentication
  bool trap_heap = false;
  bool memory_map = false;
  bool version = false;
  bool help = false;
};

/// Why a command line is refused.
struct CommandLineFault {
  const char* word = "";          ///< the option at fault
  const char* reason = "";        ///< rest of the sentence that begins with `word`
  const char* nearest = nullptr;  ///< if `word` is no option, the option that is spelled most like it
};

/// Prints the usage on standard output.
void print_usage();

/// Whether `store` is the address of a PostgreSQL server.
[[nodiscard]] bool is_server(const char* store);
/// Whether the options name stages for a process that is not the primary.
[[nodiscard]] bool joins_flight(const Options& options);

/// Returns false and sets `fault` if an option is unknown, lacks its value, contradicts another one, or is missing.
[[nodiscard]] bool parse(int argc, char** argv, Options& options, CommandLineFault& fault);
/// Parses the value of --camera (print_usage()): 6, 10, 11 or 14 numbers, or 6 numbers, the word fisheye and 4 numbers;
/// then possibly the word readout and a number. Returns false for other text.
[[nodiscard]] bool parse_camera(const char* text, CameraModel& camera);
/// Parses `WIDTHxHEIGHT`, both at least 1. Returns false for other text.
[[nodiscard]] bool parse_size(const char* text, std::int32_t& width, std::int32_t& height);
/// Prints on standard error what an option needs in place of `text`, and returns false.
bool refused(const char* needs, const char* text);
/// Reads the mission file, if one is given. Returns false, with a message on standard error, if it is refused.
[[nodiscard]] bool read_mission(const Options& options, MissionParameters& mission);
/// Read the real-time priority, 1 to 99, and the lease of the writers' lock, 1 to 3600 s, if they are given. Return
/// false, with a message on standard error, for other text.
[[nodiscard]] bool read_priority(const Options& options, int& priority);
[[nodiscard]] bool read_lock_lease(const Options& options, int& seconds);

}  // namespace ilp
