// The bodies over which a flight can be anchored, with the figures of the IAU's report of 2015
// (doi:10.1007/s10569-017-9805-5) as PROJ has them; the Earth's is WGS 84.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace ilp::exports {

struct Body {
  const char* key;     ///< as the anchor file names it
  const char* name;    ///< for people
  const char* crs;     ///< of longitude (east positive) and latitude, for PROJ
  const char* figure;  ///< for people
  /// No camera of ours is lower or higher, in metres from the figure.
  double lowest_m, highest_m;
};

[[nodiscard]] std::span<const Body> bodies();
/// Null for a name that is none.
[[nodiscard]] const Body* find_body(std::string_view key);
/// "mars, titan, ..."
[[nodiscard]] std::string body_names();

/// The body that a flight's own description names (`source` of the flight info: "simulated world, scenario titan-shore,
/// seed 1"), null where it names none.
[[nodiscard]] const Body* flown_body(std::string_view description);

}  // namespace ilp::exports
