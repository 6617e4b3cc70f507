// The widths of fields that ECSS-E-ST-70-41C leaves to a mission: one table row per supported ground system.
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
  bool interval_in_seconds = false;  ///< true: seconds as float32; false: whole milliseconds in 4 octets
  // ST[05]
  std::uint8_t event_count = 2;
  std::uint8_t event_id = 2;
  std::uint8_t event_reporter = 1;  ///< number of the component, in the auxiliary data
  std::uint8_t event_value = 8;     ///< each of the two values of the Status, signed, in the auxiliary data
  bool events_one_and_all = false;  ///< TC[5,5] and [5,6] have no list and concern every event
  // ST[11]
  std::uint8_t insert_count = 2;    ///< count in TC[11,4]
  std::uint8_t schedule_count = 2;  ///< count in the other lists
  std::uint8_t sub_schedule = 0;
  std::uint8_t group = 0;
  std::uint8_t request_id_padding = 0;  ///< zero octets before source ID, APID and sequence count
  // ST[20]
  std::uint8_t parameter_count = 2;
  std::uint8_t parameter_id = 2;
  TimeFormat time;
};

inline constexpr auto tailoring_count = static_cast<std::size_t>(GroundSystem::count);
/// All rows, in the order of GroundSystem.
[[nodiscard]] std::span<const Tailoring, tailoring_count> tailorings();
/// Returns the row of a ground system (mission parameter [link] tailoring), or the first row for an unknown number.
/// `cuc_time` ([link] cuc_time): times have CUC with 4 + 3 octets and the agency's epoch, s of UTC since 1958.
[[nodiscard]] Tailoring tailoring_of(GroundSystem tailoring, bool cuc_time, double agency_epoch_s);

/// Reads the number of items of a list from a count of `octets` octets; 1 if `octets` is 0.
[[nodiscard]] inline std::uint32_t read_count(std::uint8_t octets, ByteReader& in) {
  return octets == 0 ? 1 : static_cast<std::uint32_t>(in.number(octets));
}
/// Appends the count in `octets` octets; nothing if `octets` is 0.
inline void write_count(std::uint8_t octets, std::size_t count, ByteWriter& out) {
  if (octets != 0) out.number(count, octets);
}

}  // namespace ilp
