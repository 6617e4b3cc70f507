// The widths of fields that ECSS-E-ST-70-41C leaves to a mission, as data: one table row per supported ground system.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "cfg/choices.hpp"
#include "fsw/packets/time_code.hpp"

namespace ilp {

/// Widths in octets. A list without a count (width 0) holds exactly one item.
struct Tailoring {
  const char* name = "";
  // ST[01]
  std::uint8_t failure_code = 2;
  std::uint8_t step = 1;
  // ST[03]
  std::uint8_t report_count = 2;
  std::uint8_t report_id = 1;        ///< SID
  bool interval_in_seconds = false;  ///< float32; otherwise whole milliseconds, 4 octets
  // ST[05]
  std::uint8_t event_count = 2;
  std::uint8_t event_id = 2;
  std::uint8_t event_reporter = 1;  ///< in the auxiliary data: number of the component
  std::uint8_t event_value = 8;     ///< each of the two values, signed
  bool events_one_and_all = false;  ///< TC[5,5] and [5,6] have no list, so every event is meant
  // ST[11]
  std::uint8_t insert_count = 2;    ///< of TC[11,4]
  std::uint8_t schedule_count = 2;  ///< of the other lists
  std::uint8_t sub_schedule = 0;
  std::uint8_t group = 0;
  std::uint8_t request_id_padding = 0;  ///< zeros before source ID, APID, count
  // ST[20]
  std::uint8_t parameter_count = 2;
  std::uint8_t parameter_id = 2;
  TimeFormat time;
};

inline constexpr auto tailoring_count = static_cast<std::size_t>(GroundSystem::count);
/// In the order of GroundSystem.
[[nodiscard]] std::span<const Tailoring, tailoring_count> tailorings();
/// The row of the mission parameter [link] tailoring; the first one for any other number. With [link] cuc_time every
/// row has CUC 4+3 with the agency's epoch.
[[nodiscard]] Tailoring tailoring_of(GroundSystem tailoring, bool cuc_time, double agency_epoch_s);

/// The number of items of a list; 1 where the tailoring has no count.
[[nodiscard]] inline std::uint32_t read_count(std::uint8_t octets, ByteReader& in) {
  return octets == 0 ? 1 : static_cast<std::uint32_t>(in.number(octets));
}
inline void write_count(std::uint8_t octets, std::size_t count, ByteWriter& out) {
  if (octets != 0) out.number(count, octets);
}

}  // namespace ilp
