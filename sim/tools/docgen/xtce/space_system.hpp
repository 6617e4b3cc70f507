// Builds one SpaceSystem of an XTCE database: types, parameters, containers, commands.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "fsw/base/enumeration.hpp"
#include "sim/tools/docgen/xtce/xml.hpp"

namespace ilp::docgen {

/// Encoding and meaning of a number in a packet.
struct NumberForm {
  std::size_t bits = 8;
  bool is_signed = false;
  bool is_float = false;
  std::string unit = {};
  double scale = 1;                          ///< value in `unit` = number in the packet * scale
  std::optional<double> min = {}, max = {};  ///< range of the value in `unit`
};

struct Choice {
  std::uint64_t number;
  std::string label;
  std::string meaning;
};
[[nodiscard]] std::vector<Choice> choices_of(EnumValues values);

/// The text as a valid XTCE name: letters, digits and `_`; `/` becomes `_per_`.
[[nodiscard]] std::string xtce_name(const std::string& text);
/// A number with all digits; integers have no exponent.
[[nodiscard]] std::string xtce_number(double value);

enum class Side : std::uint8_t { parameter, argument };

/// References to names of a parent need no path, because XTCE searches upwards. All names that a SpaceSystem defines
/// begin with its `prefix`, so that they stay distinct after `flatten`.
class SpaceSystem {
 public:
  SpaceSystem(std::string name, std::string description, std::string prefix = {})
      : name_(std::move(name)), description_(std::move(description)), prefix_(std::move(prefix)) {}

  /// `name` with the prefix.
  [[nodiscard]] std::string named(const std::string& name) const { return prefix_ + name; }

  // Functions that add a type, once for each name and side. They return the name with the prefix.
  std::string number_type(Side side, const std::string& name, const NumberForm& form);
  /// A type whose name is made from the form.
  std::string number_type(Side side, const NumberForm& form);
  std::string choice_type(Side side, const std::string& name, std::size_t bits, const std::vector<Choice>& choices);
  /// `attributes` of the element `Encoding`; `reference` is an element of ReferenceTime with its content.
  std::string time_type(Side side, const std::string& name, std::size_t bits, double scale, double offset,
                        const std::string& offset_from, const std::string& epoch);
  std::string bytes_type(Side side, const std::string& name, std::size_t bytes);
  /// Octets of variable length: `slope` * value of `counted` + `intercept`, in bits.
  std::string sized_type(Side side, const char* kind, const std::string& name, const std::string& counted,
                         std::int64_t slope, std::int64_t intercept);

  /// Adds a parameter unless the name is known, and returns the name with the prefix. Throws std::runtime_error if the
  /// known parameter has another type.
  std::string parameter(const std::string& name, const std::string& type, const std::string& description);

  /// Complete elements SequenceContainer and MetaCommand.
  Xml containers{4};
  Xml commands{4};
  std::vector<SpaceSystem> children;

  /// Moves all definitions of the descendants into this SpaceSystem and removes the children. Throws std::runtime_error
  /// if a type or parameter is defined twice.
  void flatten();

  /// The SpaceSystem as XML, indented by `depth` levels.
  [[nodiscard]] std::string text(std::size_t depth, const Xml::Attributes& attributes, const std::string& header) const;

 private:
  bool first(Side side, const std::string& name);
  Xml& types(Side side) { return side == Side::parameter ? parameter_types_ : argument_types_; }

  /// Moves the definitions of a descendant into this SpaceSystem.
  void take(SpaceSystem& descendant);

  std::string name_, description_, prefix_;
  std::set<std::string> parameter_type_names_, argument_type_names_;
  std::map<std::string, std::string> parameter_names_;
  Xml parameter_types_{4}, argument_types_{4}, parameters_{4};
};

}  // namespace ilp::docgen
