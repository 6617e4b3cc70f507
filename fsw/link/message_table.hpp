// Every message of the services: direction, name and application data. The interface document follows this table; a
// test holds it against what the flight software takes.
#pragma once

#include <cstdint>
#include <span>

namespace ilp {

struct MessageInfo {
  std::uint8_t service, subtype;
  bool telecommand;    ///< else telemetry
  const char* name;    ///< of the standard
  const char* layout;  ///< of the application or source data; widths w(...) are those of the tailoring
  const char* remark;
};

/// In the order of service and subtype.
[[nodiscard]] std::span<const MessageInfo> message_table();

}  // namespace ilp
