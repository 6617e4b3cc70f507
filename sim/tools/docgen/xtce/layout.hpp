// Parses the layout of a message from its text in fsw/packets/message_table.cpp, and lists the widths of a tailoring by
// name.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "fsw/packets/tailoring.hpp"

namespace ilp::docgen {

/// A width in Tailoring with the name that layouts use: w(name).
struct Width {
  const char* name;
  std::uint8_t Tailoring::*octets;
  const char* none;  ///< what a width of 0 means
};
[[nodiscard]] std::span<const Width> tailoring_widths();

enum class ItemKind : std::uint8_t {
  number,       ///< `octets` octets
  count,        ///< the number of items of the list that follows
  list,         ///< `items`, repeated by the count
  time,         ///< in the tailoring's time code
  request,      ///< request id of service 11: source, APID and sequence count of a telecommand
  telecommand,  ///< a complete packet
  text,         ///< up to the packet CRC
  report,       ///< values of the report that the SID names
  value,        ///< value of the parameter that the item before names
  function,     ///< name of 8 characters
  arguments     ///< arguments of the function that the item before names
};

struct LayoutItem {
  ItemKind kind = ItemKind::number;
  std::string name = {};
  std::string width = {};  ///< number: name of its width in the tailoring; else empty
  std::size_t octets = 0;
  bool is_signed = false;
  bool is_float = false;
  std::string unit = {};
  std::vector<LayoutItem> items = {};
};

/// Parses a layout. Items that the tailoring does not have are left out. Throws std::runtime_error for an invalid text.
[[nodiscard]] std::vector<LayoutItem> read_layout(const std::string& text, const Tailoring& tailoring);

}  // namespace ilp::docgen
