// Generates the parts of the XTCE database.
#pragma once

#include <string>

#include "fsw/base/status.hpp"
#include "fsw/packets/tailoring.hpp"
#include "sim/tools/docgen/xtce/layout.hpp"
#include "sim/tools/docgen/xtce/space_system.hpp"

namespace ilp::docgen {

/// What the parts need to know of the mission.
struct XtceMission {
  Tailoring tailoring;
  std::uint16_t apid = 0;
  bool flat = false;  ///< everything is in one SpaceSystem

  /// Prefix of all names in the SpaceSystem `path`: the path if the database is flat, else empty.
  [[nodiscard]] std::string prefix_of(const std::string& path) const { return flat ? path + "_" : ""; }
  /// Reference from the root to a name in the SpaceSystem `space`.
  [[nodiscard]] std::string reference(const std::string& space, const std::string& name) const {
    return space + (flat ? "_" : "/") + name;
  }
};

/// Names of the SpaceSystems of events, mission parameters and housekeeping.
inline constexpr const char* events_space = "events";
inline constexpr const char* parameters_space = "parameters";
inline constexpr const char* housekeeping_space = "housekeeping";

/// The name of an item's type, which is added to `root`: an enumeration for SIDs, events, failure codes, components and
/// parameters.
[[nodiscard]] std::string item_type(Side side, const LayoutItem& item, SpaceSystem& root);

/// The name of a value of an event in the SpaceSystem of events; `which` is 'a' or 'b'.
[[nodiscard]] std::string event_value_name(StatusCode code, char which);
/// The name of this value's type, which is added to `space`: an enumeration if its numbers have names.
[[nodiscard]] std::string event_value_type(StatusCode code, char which, std::size_t octets, SpaceSystem& space);

/// Adds a comparison with the raw number in the packet, not with a label.
void comparison(const std::string& parameter, std::uint64_t value, Xml& xml);

/// Adds the packet headers, and a container for each report of the message table.
void add_telemetry(const XtceMission& mission, SpaceSystem& root);
/// Makes the SpaceSystem of housekeeping, with a nested one for each report.
[[nodiscard]] SpaceSystem housekeeping(const XtceMission& mission, SpaceSystem& root);
/// Makes the SpaceSystem of events with their two values each.
[[nodiscard]] SpaceSystem events(const XtceMission& mission);
/// Makes the SpaceSystem of mission parameters with a command for each that sets it.
[[nodiscard]] SpaceSystem parameters(const XtceMission& mission, SpaceSystem& root);
/// Adds a command for each telecommand of the message table and for each function of TC[8,1].
void add_telecommands(const XtceMission& mission, SpaceSystem& root);

struct CommandArgument {
  std::string name, type, initial, description;
};
/// Adds a command with this service and subtype. `entries` are the elements of its container, in the order of the
/// packet.
void add_command(const std::string& name, const std::string& description, std::uint8_t service, std::uint8_t subtype,
                 const std::vector<CommandArgument>& arguments, const std::string& entries, SpaceSystem& space);
/// A container entry for a fixed number.
[[nodiscard]] std::string fixed_entry(const char* name, std::uint64_t value, std::size_t octets);
[[nodiscard]] std::string argument_entry(const std::string& name);

}  // namespace ilp::docgen
