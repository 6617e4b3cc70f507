// One SpaceSystem of an XTCE database while it is written: types, parameters, containers, commands.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "fsw/base/enumeration.hpp"
#include "sim/tools/docgen/xtce/xml.hpp"

namespace ilp::docgen {

/// How a number stands in a packet, and what it means.
struct NumberForm {
  std::size_t bits = 8;
  bool is_signed = false;
  bool is_float = false;
  std::string unit = {};
  double scale = 1;                          ///< the value in the unit is the number of the packet times this
  std::optional<double> min = {}, max = {};  ///< of the value in the unit
};

struct Choice {
  std::uint64_t number;
  std::string label;
  std::string meaning;
};
[[nodiscard]] std::vector<Choice> choices_of(EnumValues values);

/// A name that XTCE takes: letters, digits and `_`.
[[nodiscard]] std::string xtce_name(const std::string& text);
/// A number with all its digits.
[[nodiscard]] std::string xtce_number(double value);

enum class Side : std::uint8_t { parameter, argument };

/// References to names of a parent need no path: they are searched upwards. All that a SpaceSystem defines begins with
/// its `prefix`, which keeps its names apart where all of them stand in one SpaceSystem.
class SpaceSystem {
 public:
  SpaceSystem(std::string name, std::string description, std::string prefix = {})
      : name_(std::move(name)), description_(std::move(description)), prefix_(std::move(prefix)) {}

  /// The name under which something of this SpaceSystem is defined.
  [[nodiscard]] std::string named(const std::string& name) const { return prefix_ + name; }

  // Types are written once for each name and side. They return the name under which they are defined.
  std::string number_type(Side side, const std::string& name, const NumberForm& form);
  /// The name follows from the form.
  std::string number_type(Side side, const NumberForm& form);
  std::string choice_type(Side side, const std::string& name, std::size_t bits, const std::vector<Choice>& choices);
  /// `attributes` of the element `Encoding`; `reference` is an element of ReferenceTime with its content.
  std::string time_type(Side side, const std::string& name, std::size_t bits, double scale, double offset,
                        const std::string& offset_from, const std::string& epoch);
  std::string bytes_type(Side side, const std::string& name, std::size_t bytes);
  /// Octets by a number: `slope` x the value of `parameter` + `intercept`, in bits.
  std::string sized_type(Side side, const char* kind, const std::string& name, const std::string& counted,
                         std::int64_t slope, std::int64_t intercept);

  /// Returns the name under which it is defined. A parameter of a known name is that one. std::runtime_error if it has
  /// another type.
  std::string parameter(const std::string& name, const std::string& type, const std::string& description);

  /// Whole elements SequenceContainer and MetaCommand.
  Xml containers{4};
  Xml commands{4};
  std::vector<SpaceSystem> children;

  /// Takes in all that its children define, and has none any more. std::runtime_error if a type or parameter is defined
  /// twice.
  void flatten();

  [[nodiscard]] std::string text(std::size_t depth, const Xml::Attributes& attributes, const std::string& header) const;

 private:
  bool first(Side side, const std::string& name);
  Xml& types(Side side) { return side == Side::parameter ? parameter_types_ : argument_types_; }

  /// All that a descendant defines.
  void take(SpaceSystem& descendant);

  std::string name_, description_, prefix_;
  std::set<std::string> parameter_type_names_, argument_type_names_;
  std::map<std::string, std::string> parameter_names_;
  Xml parameter_types_{4}, argument_types_{4}, parameters_{4};
};

}  // namespace ilp::docgen
