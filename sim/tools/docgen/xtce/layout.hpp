// The layout of a message, read from its text in fsw/packets/message_table.cpp, and the widths of a tailoring by name.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "fsw/packets/tailoring.hpp"

namespace ilp::docgen {

/// A width in Tailoring, by the name that layouts use: w(name).
struct Width {
  const char* name;
  std::uint8_t Tailoring::*octets;
  const char* none;  ///< what a width of 0 means
};
[[nodiscard]] std::span<const Width> tailoring_widths();

enum class ItemKind : std::uint8_t {
  number,       ///< `octets` octets
  count,        ///< the number of items of the list that follows
  list,         ///< `items`, as often as the count says
  time,         ///< in the tailoring's form
  request,      ///< of service 11: source, APID and sequence count of a telecommand
  telecommand,  ///< a whole packet
  text,         ///< up to the packet CRC
  report,       ///< the values of the report that the SID names
  value,        ///< of the parameter that was named before it
  function,     ///< a name of 8 characters
  arguments     ///< of the function that was named before it
};

struct LayoutItem {
  ItemKind kind = ItemKind::number;
  std::string name = {};
  std::string width = {};  ///< number: its name in the tailoring; otherwise empty
  std::size_t octets = 0;
  bool is_signed = false;
  bool is_float = false;
  std::string unit = {};
  std::vector<LayoutItem> items = {};
};

/// Items that the tailoring does not have are left out. std::runtime_error for a text that is not understood.
[[nodiscard]] std::vector<LayoutItem> read_layout(const std::string& text, const Tailoring& tailoring);

}  // namespace ilp::docgen
