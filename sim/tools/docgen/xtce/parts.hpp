// The parts of which the XTCE database is put together.
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

  /// Where the names of a SpaceSystem below `path` begin: with their place where there are no SpaceSystems.
  [[nodiscard]] std::string prefix_of(const std::string& path) const { return flat ? path + "_" : ""; }
  /// A name of a SpaceSystem below the root, as the root refers to it.
  [[nodiscard]] std::string reference(const std::string& space, const std::string& name) const {
    return space + (flat ? "_" : "/") + name;
  }
};

/// Housekeeping values, values of events and mission parameters keep these names in their SpaceSystems.
inline constexpr const char* events_space = "events";
inline constexpr const char* parameters_space = "parameters";
inline constexpr const char* housekeeping_space = "housekeeping";

/// The type of an item: an enumeration for SIDs, events, failure codes, components and parameters.
[[nodiscard]] std::string item_type(Side side, const LayoutItem& item, SpaceSystem& root);

/// The name of a value of an event in the SpaceSystem of events; `which` is 'a' or 'b'.
[[nodiscard]] std::string event_value_name(StatusCode code, char which);
/// Its type: an enumeration where its numbers have names.
[[nodiscard]] std::string event_value_type(StatusCode code, char which, std::size_t octets, SpaceSystem& space);

// Comparisons are made with the number of the packet, not with a label.
void comparison(const std::string& parameter, std::uint64_t value, Xml& xml);

/// Headers of packets, and a container for each report of the message table.
void add_telemetry(const XtceMission& mission, SpaceSystem& root);
/// A SpaceSystem for each report of housekeeping.
[[nodiscard]] SpaceSystem housekeeping(const XtceMission& mission, SpaceSystem& root);
/// The two values of every event.
[[nodiscard]] SpaceSystem events(const XtceMission& mission);
/// The mission parameters, and a command for each that sets it.
[[nodiscard]] SpaceSystem parameters(const XtceMission& mission, SpaceSystem& root);
/// A command for each telecommand of the message table and each function of TC[8,1].
void add_telecommands(const XtceMission& mission, SpaceSystem& root);

struct CommandArgument {
  std::string name, type, initial, description;
};
/// A command of service and subtype. `entries` are elements of its container, in the order of the packet.
void add_command(const std::string& name, const std::string& description, std::uint8_t service, std::uint8_t subtype,
                 const std::vector<CommandArgument>& arguments, const std::string& entries, SpaceSystem& space);
/// An entry of a fixed number.
[[nodiscard]] std::string fixed_entry(const char* name, std::uint64_t value, std::size_t octets);
[[nodiscard]] std::string argument_entry(const std::string& name);

}  // namespace ilp::docgen
