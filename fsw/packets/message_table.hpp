// Every message of the services: direction, name and application data. The interface document follows this table, and a
// test compares it with what the flight software accepts.
#pragma once

#include <cstdint>
#include <span>

namespace ilp {

struct MessageInfo {
  std::uint8_t service, subtype;
  bool telecommand;    ///< false: telemetry
  const char* name;    ///< name in the standard
  const char* layout;  ///< layout of the application or source data; widths w(...) are those of the tailoring
  const char* remark;
};

/// All messages, in ascending order of service and subtype.
[[nodiscard]] std::span<const MessageInfo> message_table();

}  // namespace ilp
